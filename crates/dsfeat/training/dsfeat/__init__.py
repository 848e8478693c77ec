"""Training of DSFeat: a network that tells static, distinctive image regions from dynamic ones."""
