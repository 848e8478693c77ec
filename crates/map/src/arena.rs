//! Copy-on-write storage by dense id: a clone shares everything, a write copies one chunk of pointers and one item.

use std::marker::PhantomData;
use std::sync::Arc;

use crate::ids::Id;

/// Slots per chunk: a write beside a snapshot copies this many pointers.
const CHUNK: usize = 64;

/// What an id names. `R` is what remains of an item that another one has replaced.
#[derive(Clone)]
enum Slot<T, R> {
    Live(Arc<T>),
    Forwarded(Arc<R>),
    Removed,
}

/// Items `T` under ids `I` given out in order and never reused.
pub(crate) struct Arena<I, T, R> {
    chunks: Vec<Arc<Vec<Slot<T, R>>>>,
    len: usize,
    n_live: usize,
    id: PhantomData<I>,
}

impl<I, T, R> Clone for Arena<I, T, R> {
    fn clone(&self) -> Self {
        Arena { chunks: self.chunks.clone(), len: self.len, n_live: self.n_live, id: PhantomData }
    }
}

impl<I, T, R> Default for Arena<I, T, R> {
    fn default() -> Self {
        Arena { chunks: Vec::new(), len: 0, n_live: 0, id: PhantomData }
    }
}

impl<I: Id, T: Clone, R: Clone> Arena<I, T, R> {
    /// Number of ids given out so far, removed ones included.
    pub(crate) fn len(&self) -> usize {
        self.len
    }

    pub(crate) fn n_live(&self) -> usize {
        self.n_live
    }

    pub(crate) fn next_id(&self) -> I {
        I::from_index(self.len)
    }

    /// Stores an item under the next id.
    pub(crate) fn push(&mut self, item: T) -> I {
        let id = self.next_id();
        self.push_slot(Slot::Live(Arc::new(item)));
        self.n_live += 1;
        id
    }

    fn push_slot(&mut self, slot: Slot<T, R>) {
        if self.len.is_multiple_of(CHUNK) {
            self.chunks.push(Arc::new(Vec::with_capacity(CHUNK)));
        }
        let last = self.len / CHUNK;
        Arc::make_mut(&mut self.chunks[last]).push(slot);
        self.len += 1;
    }

    /// Uses up the next id for an item that was there once: for a map that is read from a file.
    pub(crate) fn push_gone(&mut self, replaced_by: Option<R>) {
        let slot = replaced_by.map_or(Slot::Removed, |r| Slot::Forwarded(Arc::new(r)));
        self.push_slot(slot);
    }

    pub(crate) fn get(&self, id: I) -> Option<&T> {
        self.live_arc(id.index()).map(|item| &**item)
    }

    /// An item that must be there: by an invariant of the map or after validation.
    pub(crate) fn live(&self, id: I) -> &T {
        self.get(id).unwrap_or_else(|| panic!("map is broken: {id} does not exist"))
    }

    /// Write access to an item that must be there; copies it if a snapshot shares it.
    pub(crate) fn live_mut(&mut self, id: I) -> &mut T {
        match self.slot_mut(id) {
            Slot::Live(item) => Arc::make_mut(item),
            Slot::Forwarded(_) | Slot::Removed => panic!("map is broken: {id} does not exist"),
        }
    }

    /// Takes an item out for ever, leaving word of what replaced it, if anything did.
    pub(crate) fn remove(&mut self, id: I, replaced_by: Option<R>) {
        let slot = self.slot_mut(id);
        let was_live = matches!(slot, Slot::Live(_));
        *slot = replaced_by.map_or(Slot::Removed, |r| Slot::Forwarded(Arc::new(r)));
        self.n_live -= usize::from(was_live);
    }

    /// What replaced a removed item.
    pub(crate) fn forward(&self, id: I) -> Option<&R> {
        match self.slot(id.index())? {
            Slot::Forwarded(r) => Some(r),
            Slot::Live(_) | Slot::Removed => None,
        }
    }

    /// Write access to what replaced a removed item.
    pub(crate) fn forward_mut(&mut self, id: I) -> Option<&mut R> {
        match self.slot_mut(id) {
            Slot::Forwarded(r) => Some(Arc::make_mut(r)),
            Slot::Live(_) | Slot::Removed => None,
        }
    }

    /// Live items in order of their ids.
    pub(crate) fn iter(&self) -> impl DoubleEndedIterator<Item = (I, &T)> {
        self.chunks.iter().enumerate().flat_map(|(c, chunk)| {
            chunk.iter().enumerate().filter_map(move |(i, slot)| match slot {
                Slot::Live(item) => Some((I::from_index(c * CHUNK + i), &**item)),
                Slot::Forwarded(_) | Slot::Removed => None,
            })
        })
    }

    /// Ids, in order, whose item may differ from the one in an older snapshot, with the item if it is there now. What both
    /// share is passed over a chunk at a time.
    pub(crate) fn changed_since<'a>(&'a self, older: &'a Self) -> impl Iterator<Item = (I, Option<&'a T>)> {
        let n_chunks = self.chunks.len().max(older.chunks.len());
        let differs = move |c: &usize| match (self.chunks.get(*c), older.chunks.get(*c)) {
            (Some(new), Some(old)) => !Arc::ptr_eq(new, old),
            _ => true,
        };
        (0..n_chunks).filter(differs).flat_map(|c| c * CHUNK..(c + 1) * CHUNK).filter_map(move |index| {
            let (new, old) = (self.live_arc(index), older.live_arc(index));
            let same = match (new, old) {
                (Some(new), Some(old)) => Arc::ptr_eq(new, old),
                (None, None) => true,
                _ => false,
            };
            (!same).then(|| (I::from_index(index), new.map(|item| &**item)))
        })
    }

    fn live_arc(&self, index: usize) -> Option<&Arc<T>> {
        match self.slot(index)? {
            Slot::Live(item) => Some(item),
            Slot::Forwarded(_) | Slot::Removed => None,
        }
    }

    fn slot(&self, index: usize) -> Option<&Slot<T, R>> {
        self.chunks.get(index / CHUNK)?.get(index % CHUNK)
    }

    fn slot_mut(&mut self, id: I) -> &mut Slot<T, R> {
        let index = id.index();
        &mut Arc::make_mut(&mut self.chunks[index / CHUNK])[index % CHUNK]
    }
}
