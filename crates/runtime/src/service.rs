//! A stage that answers questions in their order: on a thread of its own, or in turn when the answer is wanted.

use crossbeam::channel::{Receiver, Sender, bounded};

use crate::failure::{Halt, caught};

/// Where questions go.
pub(crate) enum Service<Q, A> {
    /// Answers are computed when they are waited for.
    InTurn(&'static str, Box<dyn FnMut(Q) -> A + Send>),
    /// Answers are computed on a thread that reads this channel.
    Thread(Sender<Asked<Q, A>>),
}

/// A question with the way back for its answer. The way back holds one answer, so that answering never blocks.
pub(crate) type Asked<Q, A> = (Q, Sender<A>);

/// An answer to come.
pub(crate) enum Answer<Q, A> {
    /// Not yet computed.
    Open(Q),
    /// Computed elsewhere.
    Coming(Receiver<A>),
}

impl<Q, A> Service<Q, A> {
    /// Asks; blocks only while many questions are waiting.
    pub(crate) fn ask(&self, question: Q) -> Result<Answer<Q, A>, Halt> {
        match self {
            Service::InTurn(..) => Ok(Answer::Open(question)),
            Service::Thread(asked) => {
                let (back, answer) = bounded(1);
                asked.send((question, back)).map_err(|_| Halt::Gone)?;
                Ok(Answer::Coming(answer))
            }
        }
    }

    /// Waits for the answer. Answers must be waited for in the order of the questions, or be dropped.
    pub(crate) fn wait(&mut self, answer: Answer<Q, A>) -> Result<A, Halt> {
        match (self, answer) {
            (Service::InTurn(stage, work), Answer::Open(question)) => {
                caught(stage, || work(question)).map_err(Halt::Failed)
            }
            (_, Answer::Coming(answer)) => answer.recv().map_err(|_| Halt::Gone),
            (Service::Thread(_), Answer::Open(_)) => Err(Halt::Gone),
        }
    }
}

impl<Q, A> Answer<Q, A> {
    /// The channel that the answer comes through, if it does.
    pub(crate) fn channel(&self) -> Option<&Receiver<A>> {
        match self {
            Answer::Open(_) => None,
            Answer::Coming(answer) => Some(answer),
        }
    }
}
