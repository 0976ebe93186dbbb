//! What stages read: handles while the flow is written, values while it runs.
//!
//! ```
//! use runner::{Dag, Text};
//!
//! let mut dag: Dag<()> = Dag::new("shout");
//! let (first, second) = (dag.input(Text("a lid".into())), dag.input(Text("a pot".into())));
//! assert_eq!([first.node(), second.node()], [0, 1]);
//! ```

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use super::artefact::Artefact;

/// A decoded artefact on its way from one stage to another.
pub type Value = Arc<dyn Any + Send + Sync>;

/// The promise of an artefact: what `stage` returns and the next stage takes.
#[derive(Debug)]
pub struct Handle<A> {
    node: usize,
    artefact: PhantomData<fn() -> A>,
}

impl<A> Clone for Handle<A> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<A> Copy for Handle<A> {}

impl<A> Handle<A> {
    pub(super) fn of(node: usize) -> Self {
        Self { node, artefact: PhantomData }
    }

    /// Index of the node that makes the artefact.
    pub fn node(self) -> usize {
        self.node
    }
}

/// What a stage takes: one `Arc<A>`, or a tuple of them.
pub trait Inputs<T>: Sized {
    /// The handles that stand for them in the graph.
    type Handles;
    /// The nodes behind the handles.
    fn nodes(handles: Self::Handles) -> Vec<usize>;
    /// The values, if they are of these types.
    fn of(values: &[Value]) -> Option<Self>;
}

fn cast<A: Any + Send + Sync>(value: &Value) -> Option<Arc<A>> {
    Arc::clone(value).downcast().ok()
}

impl<T, A: Artefact<T>> Inputs<T> for Arc<A> {
    type Handles = Handle<A>;
    fn nodes(handle: Handle<A>) -> Vec<usize> {
        vec![handle.node]
    }
    fn of(values: &[Value]) -> Option<Self> {
        cast(values.first()?)
    }
}

impl<T, A: Artefact<T>, B: Artefact<T>> Inputs<T> for (Arc<A>, Arc<B>) {
    type Handles = (Handle<A>, Handle<B>);
    fn nodes((a, b): Self::Handles) -> Vec<usize> {
        vec![a.node, b.node]
    }
    fn of(values: &[Value]) -> Option<Self> {
        Some((cast(values.first()?)?, cast(values.get(1)?)?))
    }
}

impl<T, A: Artefact<T>, B: Artefact<T>, C: Artefact<T>> Inputs<T> for (Arc<A>, Arc<B>, Arc<C>) {
    type Handles = (Handle<A>, Handle<B>, Handle<C>);
    fn nodes((a, b, c): Self::Handles) -> Vec<usize> {
        vec![a.node, b.node, c.node]
    }
    fn of(values: &[Value]) -> Option<Self> {
        Some((cast(values.first()?)?, cast(values.get(1)?)?, cast(values.get(2)?)?))
    }
}
