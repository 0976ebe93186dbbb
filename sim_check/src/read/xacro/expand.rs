//! The expansion itself, element by element.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::macros::{Frame, Kind, Macro, Symbol, params};
use crate::read::element::{self, Element, Space};
use crate::read::meshes::Shelf;
use crate::read::xml::shown;

/// Deepest nesting of calls and files; most elements that are made.
const DEEPEST: usize = 64;
const MOST: usize = 200_000;
/// Most faults that are listed.
const LISTED: usize = 50;

/// What an expansion knows at a moment.
pub(super) struct Machine<'s> {
    pub shelf: &'s mut Shelf,
    pub frames: Vec<Frame>,
    pub macros: BTreeMap<String, Macro>,
    pub args: BTreeMap<String, String>,
    pub faults: Vec<String>,
    pub files: Vec<String>,
    pub depth: usize,
    calls: usize,
    made: usize,
}

type Elements = Vec<Arc<Element>>;

impl<'s> Machine<'s> {
    pub(super) fn new(shelf: &'s mut Shelf) -> Self {
        let args = shelf.places().args.clone();
        Self {
            shelf,
            frames: vec![Frame::new()],
            macros: BTreeMap::new(),
            args,
            faults: Vec::new(),
            files: Vec::new(),
            depth: 0,
            calls: 0,
            made: 0,
        }
    }

    fn fault(&mut self, element: &Element, why: impl std::fmt::Display) {
        if self.faults.len() < LISTED {
            self.faults.push(format!("line {}: `{}`: {why}", element.line, element.name));
        }
    }

    pub(super) fn root(&mut self, root: &Element) -> Element {
        let mut made = root.bare();
        made.attributes = self.attributes(root);
        made.children = self.children(&root.children);
        made
    }

    fn attributes(&mut self, of: &Element) -> Vec<(String, String)> {
        let mut all = Vec::new();
        for (name, text) in &of.attributes {
            match self.text(text) {
                Ok(value) => all.push((name.clone(), value)),
                Err(why) => {
                    self.fault(of, format!("{name}: {why}"));
                    all.push((name.clone(), text.clone()));
                }
            }
        }
        all
    }

    fn children(&mut self, of: &[Arc<Element>]) -> Elements {
        let mut all = Vec::new();
        for child in of {
            all.extend(self.element(child));
        }
        all
    }

    fn element(&mut self, of: &Arc<Element>) -> Elements {
        self.made += 1;
        if self.made > MOST {
            if self.made == MOST + 1 {
                self.fault(of, format!("at most {MOST} elements are made of macros"));
            }
            return Vec::new();
        }
        match of.space {
            Space::Other => Vec::new(),
            Space::Own => {
                let mut made = of.bare();
                made.attributes = self.attributes(of);
                made.children = self.children(&of.children);
                vec![Arc::new(made)]
            }
            Space::Xacro => self.directive(of),
        }
    }

    fn directive(&mut self, of: &Arc<Element>) -> Elements {
        match of.name.as_str() {
            "property" => self.property(of),
            "arg" => self.argument(of),
            "macro" => self.define(of),
            "include" => return self.include(of),
            "insert_block" => return self.insert(of),
            "if" | "unless" => return self.condition(of),
            "call" => {
                let Some(name) = of.get("macro").map(str::to_owned) else {
                    self.fault(of, "names no macro");
                    return Vec::new();
                };
                return match self.text(&name) {
                    Ok(name) => self.call(of, &name),
                    Err(why) => {
                        self.fault(of, why);
                        Vec::new()
                    }
                };
            }
            name => return self.call(of, name),
        }
        Vec::new()
    }

    fn property(&mut self, of: &Element) {
        let Some(name) = of.get("name").map(str::to_owned) else {
            return self.fault(of, "has no name");
        };
        let scope = of.get("scope").unwrap_or_default();
        let last = self.frames.len() - 1;
        let frame = match scope {
            "global" => 0,
            "parent" => last.saturating_sub(1),
            _ => last,
        };
        let symbol = match (of.get("value"), of.get("default")) {
            (Some(text), _) if scope.is_empty() && !names_itself(text, &name) => {
                Symbol::Lazy(text.to_owned())
            }
            (Some(text), _) => match self.value(text) {
                Ok(value) => Symbol::Known(value),
                Err(why) => return self.fault(of, why),
            },
            (None, Some(_)) if self.frames.iter().any(|f| f.contains_key(&name)) => return,
            (None, Some(text)) => Symbol::Lazy(text.to_owned()),
            (None, None) => Symbol::Block(of.children.clone()),
        };
        self.frames[frame].insert(name, symbol);
    }

    fn argument(&mut self, of: &Element) {
        let Some(name) = of.get("name").map(str::to_owned) else {
            return self.fault(of, "has no name");
        };
        if self.args.contains_key(&name) {
            return;
        }
        match of.get("default").map(str::to_owned).map(|text| self.text(&text)) {
            Some(Ok(value)) => drop(self.args.insert(name, value)),
            Some(Err(why)) => self.fault(of, why),
            None => {}
        }
    }

    fn define(&mut self, of: &Arc<Element>) {
        let Some(name) = of.get("name") else { return self.fault(of, "has no name") };
        let name = name.strip_prefix("xacro:").unwrap_or(name).to_owned();
        let params = params(of.get("params").unwrap_or_default());
        self.macros.insert(name, Macro { params, body: of.clone() });
    }

    fn include(&mut self, of: &Element) -> Elements {
        let Some(name) = of.get("filename").map(str::to_owned) else {
            self.fault(of, "names no file");
            return Vec::new();
        };
        if of.get("ns").is_some() {
            self.fault(of, "a file in a namespace of its own is not read here");
            return Vec::new();
        }
        let name = match self.text(&name) {
            Ok(name) => name,
            Err(why) => {
                self.fault(of, why);
                return Vec::new();
            }
        };
        self.calls += 1;
        let made = if self.calls > DEEPEST {
            Err(format!("files and calls nest at most {DEEPEST} deep"))
        } else {
            let text = self.shelf.text(&name);
            text.and_then(|text| element::read(&text, Some(of.line)))
        };
        let all = match made {
            Ok(root) => self.children(&root.children),
            Err(_) if of.get("optional").is_some_and(|o| o.eq_ignore_ascii_case("true")) => {
                Vec::new()
            }
            Err(why) => {
                self.files.push(format!("line {}: include of `{}`: {why}", of.line, shown(&name)));
                Vec::new()
            }
        };
        self.calls -= 1;
        all
    }

    fn insert(&mut self, of: &Element) -> Elements {
        let name = of.get("name").unwrap_or_default().to_owned();
        let name = self.text(&name).unwrap_or(name);
        let found = self.frames.iter().rev().find_map(|frame| frame.get(&name)).cloned();
        match found {
            Some(Symbol::Block(block)) => self.children(&block),
            _ => {
                self.fault(of, format!("there is no block `{}`", shown(&name)));
                Vec::new()
            }
        }
    }

    fn condition(&mut self, of: &Element) -> Elements {
        let text = of.get("value").unwrap_or_default().to_owned();
        let value = self.value(&text).and_then(|value| {
            value
                .condition()
                .ok_or_else(|| format!("`{}` is neither true nor false", value.shown()))
        });
        match value {
            Ok(holds) if holds == (of.name == "if") => self.children(&of.children),
            Ok(_) => Vec::new(),
            Err(why) => {
                self.fault(of, why);
                Vec::new()
            }
        }
    }

    fn call(&mut self, of: &Arc<Element>, name: &str) -> Elements {
        let name = name.strip_prefix("xacro:").unwrap_or(name);
        let Some(found) = self.macros.get(name).cloned() else {
            self.fault(of, format!("there is no macro `{}`", shown(name)));
            return Vec::new();
        };
        if self.calls >= DEEPEST {
            self.fault(of, format!("files and calls nest at most {DEEPEST} deep"));
            return Vec::new();
        }
        let blocks = self.children(&of.children);
        let Some(frame) = self.arguments(of, &found, blocks) else { return Vec::new() };
        self.calls += 1;
        self.frames.push(frame);
        let made = self.children(&found.body.children);
        self.frames.pop();
        self.calls -= 1;
        // What a call makes stands where the call stands.
        made.into_iter().map(|element| at_line(&element, of.line)).collect()
    }

    /// What a call gives to the parameters of its macro.
    fn arguments(&mut self, of: &Element, found: &Macro, blocks: Elements) -> Option<Frame> {
        let (mut frame, mut blocks) = (Frame::new(), blocks.into_iter());
        for param in &found.params {
            let name = &param.name;
            let symbol = match &param.kind {
                Kind::Block => blocks.next().map(|block| Symbol::Block(vec![block])),
                Kind::Inner => blocks.next().map(|block| Symbol::Block(block.children.clone())),
                Kind::Plain { default, forward } => {
                    let outer = || self.frames.iter().rev().find_map(|f| f.get(name)).cloned();
                    let said = of.get(name).map(str::to_owned);
                    let forwarded = if said.is_none() && *forward { outer() } else { None };
                    match (forwarded, said.or_else(|| default.clone())) {
                        (Some(Symbol::Lazy(text)), _) | (None, Some(text)) => {
                            match self.value(&text) {
                                Ok(value) => Some(Symbol::Known(value)),
                                Err(why) => {
                                    self.fault(of, format!("{name}: {why}"));
                                    return None;
                                }
                            }
                        }
                        (Some(symbol), _) => Some(symbol),
                        (None, None) => None,
                    }
                }
            };
            let Some(symbol) = symbol else {
                self.fault(of, format!("the macro wants `{name}`"));
                return None;
            };
            frame.insert(name.clone(), symbol);
        }
        Some(frame)
    }
}

/// Whether a text asks for a name: such a property is worked out at once, or it would never end.
fn names_itself(text: &str, name: &str) -> bool {
    text.contains('$') && text.contains(name)
}

fn at_line(of: &Arc<Element>, line: u32) -> Arc<Element> {
    if of.line == line {
        return of.clone();
    }
    let children = of.children.iter().map(|child| at_line(child, line)).collect();
    Arc::new(Element { line, children, ..Element::clone(of) })
}
