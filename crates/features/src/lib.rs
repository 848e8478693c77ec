//! ORB features, stereo and depth association, descriptor matching.
