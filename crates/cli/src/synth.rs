//! 
use crate::args::SynthArgs;use crate::exit::*; pub(crate) fn run(_a:&SynthArgs)->Result<Exit,Failure>{unimplemented!()}
