//! 
use crate::args::DemoArgs;use crate::exit::*; pub(crate) fn run(_a:&DemoArgs)->Result<Exit,Failure>{unimplemented!()}
