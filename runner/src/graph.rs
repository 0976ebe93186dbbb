//! The graph of stages: built with types, kept in the order it was written.
//!
//! ```
//! # use std::sync::Arc;
//! # use runner::{Dag, Stage, StageError, Text};
//! # struct Upper;
//! # impl Stage<()> for Upper {
//! #     type Input = Arc<Text>;
//! #     type Output = Text;
//! #     const NAME: &'static str = "upper";
//! #     fn code(&self) -> String {
//! #         "1".into()
//! #     }
//! #     fn run(&self, text: Arc<Text>, _: &()) -> Result<Text, StageError> {
//! #         Ok(Text(text.0.to_uppercase()))
//! #     }
//! # }
//! # let mut dag = Dag::new("shout");
//! # let text = dag.input(Text("a lid".into()));
//! # dag.stage(Upper, text);
//! assert_eq!(dag.name(), "shout");
//! assert!(dag.graphviz().contains("n0 -> n1 [label=\"text\"];"));
//! ```

use std::sync::Arc;

use super::artefact::{Artefact, CodecError};
use super::failure::StageError;
use super::inputs::{Handle, Inputs, Value};
use super::stage::{AnyStage, Stage};

/// A flow: inputs and stages, each after everything it reads, so that no cycle can be written.
///
/// `T` is what stages reach the outside through.
pub struct Dag<T> {
    name: &'static str,
    nodes: Vec<Node<T>>,
}

/// An input or a stage, its types forgotten.
pub(super) struct Node<T> {
    pub(super) name: &'static str,
    pub(super) artefact: Kind,
    pub(super) inputs: Vec<usize>,
    pub(super) work: Work<T>,
}

/// Where a node's artefact comes from.
pub(super) enum Work<T> {
    /// It was given.
    Given(Result<Vec<u8>, StageError>),
    /// A stage makes it.
    Stage(Arc<dyn AnyStage<T>>),
}

/// What sort of artefact a node makes.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// See [`Artefact::NAME`].
    pub name: &'static str,
    /// See [`Artefact::MEDIA_TYPE`].
    pub media_type: &'static str,
    /// See [`Artefact::FILE_NAME`].
    pub file_name: &'static str,
    pub(super) decode: fn(&[u8]) -> Result<Value, CodecError>,
}

impl Kind {
    fn of<T, A: Artefact<T>>() -> Self {
        Self {
            name: A::NAME,
            media_type: A::MEDIA_TYPE,
            file_name: A::FILE_NAME,
            decode: |bytes| Ok(Arc::new(A::decode(bytes)?)),
        }
    }
}

impl<T> Dag<T> {
    /// An empty flow.
    pub fn new(name: &'static str) -> Self {
        Self { name, nodes: Vec::new() }
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Adds something that is given.
    pub fn input<A: Artefact<T>>(&mut self, artefact: A) -> Handle<A> {
        let bytes = artefact.encode().map_err(|e| StageError::from_error(&e));
        self.push(A::NAME, Vec::new(), Work::Given(bytes))
    }

    /// Adds something that would be given: for a flow of nothing in particular.
    pub fn blank<A: Artefact<T>>(&mut self) -> Handle<A> {
        let nothing = StageError::new(format!("no {} is given", A::NAME));
        self.push(A::NAME, Vec::new(), Work::Given(Err(nothing)))
    }

    /// Adds a stage that reads what the handles stand for.
    pub fn stage<S: Stage<T>>(
        &mut self,
        stage: S,
        inputs: <S::Input as Inputs<T>>::Handles,
    ) -> Handle<S::Output> {
        self.push(S::NAME, S::Input::nodes(inputs), Work::Stage(Arc::new(stage)))
    }

    fn push<A: Artefact<T>>(
        &mut self,
        name: &'static str,
        inputs: Vec<usize>,
        work: Work<T>,
    ) -> Handle<A> {
        self.nodes.push(Node { name, artefact: Kind::of::<T, A>(), inputs, work });
        Handle::of(self.nodes.len() - 1)
    }

    /// How many stages it has.
    pub fn stages(&self) -> usize {
        self.nodes.iter().filter(|node| matches!(node.work, Work::Stage(_))).count()
    }

    pub(super) fn nodes(&self) -> &[Node<T>] {
        &self.nodes
    }

    /// The flow in Graphviz's language: inputs as ellipses, stages as boxes, artefacts on edges.
    pub fn graphviz(&self) -> String {
        let mut lines = vec![format!("digraph \"{}\" {{", self.name), "  rankdir=LR;".into()];
        for (n, node) in self.nodes.iter().enumerate() {
            let shape = if matches!(node.work, Work::Given(_)) { "ellipse" } else { "box" };
            lines.push(format!("  n{n} [label=\"{}\", shape={shape}];", node.name));
        }
        for (n, node) in self.nodes.iter().enumerate() {
            for &i in &node.inputs {
                let label = self.nodes.get(i).map_or("", |source| source.artefact.name);
                lines.push(format!("  n{i} -> n{n} [label=\"{label}\"];"));
            }
        }
        lines.push("}\n".into());
        lines.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use crate::toy;

    #[test]
    fn the_graph_prints_as_graphviz_with_artefacts_on_edges() {
        let text = toy::flow("abc").graphviz();
        assert!(text.starts_with("digraph \"toy\" {"), "{text}");
        assert!(text.contains("n0 [label=\"text\", shape=ellipse];"), "{text}");
        assert!(text.contains("n1 [label=\"upper\", shape=box];"), "{text}");
        assert!(text.contains("n0 -> n1 [label=\"text\"];"), "{text}");
        assert!(text.ends_with("}\n"));
    }
}
