//! The part of Python's pickle language that a dictionary of tensors needs. Nothing is ever called:
//! the few names PyTorch uses stand for what they build, any other name is refused or left opaque.

use std::collections::BTreeMap;

use safetensors::Dtype;

use super::checkpoint::{ConvertError, Foreign};

/// Most values a pickle may build.
const MAX_VALUES: usize = 4_000_000;

/// A value, by its place in the [`Heap`].
pub(crate) type Id = usize;

/// What a pickle builds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    /// None, True, False, floats: plain and of no interest.
    Plain,
    Int(i64),
    Text(String),
    /// A tuple or a list.
    Sequence(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    /// One of the names PyTorch uses.
    Name(Known),
    Storage(Storage),
    Tensor(TensorAt),
    /// Something built by a name that is not known; never looked into.
    Foreign(String),
}

/// Names that stand for something here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Known {
    OrderedDict,
    Tensor,
    Parameter,
    Storage(Dtype),
}

/// A run of numbers in an entry of the archive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Storage {
    pub(crate) key: String,
    pub(crate) dtype: Dtype,
    pub(crate) count: usize,
}

/// A tensor: a view of a storage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TensorAt {
    pub(crate) storage: Storage,
    pub(crate) offset: usize,
    pub(crate) shape: Vec<usize>,
    pub(crate) strides: Vec<usize>,
}

/// All values of a pickle; the last statement's result is `root`.
#[derive(Debug)]
pub(crate) struct Heap {
    pub(crate) values: Vec<Value>,
    pub(crate) root: Id,
}

/// Reads a pickle.
pub(crate) fn read(bytes: &[u8], foreign: Foreign) -> Result<Heap, ConvertError> {
    let mut machine = Machine {
        bytes,
        at: 0,
        foreign,
        values: vec![],
        stack: vec![],
        marks: vec![],
        memo: BTreeMap::new(),
    };
    loop {
        let op = machine.take(1)?[0];
        if op == b'.' {
            let root = machine.pop()?;
            return Ok(Heap { values: machine.values, root });
        }
        machine.step(op)?;
    }
}

struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    foreign: Foreign,
    values: Vec<Value>,
    stack: Vec<Id>,
    marks: Vec<usize>,
    memo: BTreeMap<u32, Id>,
}

impl<'a> Machine<'a> {
    fn error(&self, what: impl std::fmt::Display) -> ConvertError {
        ConvertError::Pickle(format!("at byte {}: {what}", self.at))
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], ConvertError> {
        let end = self.at.checked_add(count);
        let found = end.and_then(|end| self.bytes.get(self.at..end));
        let found = found.ok_or_else(|| self.error("it ends in the middle"))?;
        self.at += count;
        Ok(found)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], ConvertError> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        Ok(out)
    }

    fn text(&mut self, length: usize) -> Result<String, ConvertError> {
        let bytes = self.take(length)?;
        let text = std::str::from_utf8(bytes);
        text.map(str::to_owned).map_err(|_| self.error("a text is not UTF-8"))
    }

    fn line(&mut self) -> Result<String, ConvertError> {
        let rest = self.bytes.get(self.at..).unwrap_or(&[]);
        let length = rest.iter().take(1024).position(|&b| b == b'\n');
        let length = length.ok_or_else(|| self.error("a name without an end"))?;
        let text = self.text(length)?;
        self.at += 1;
        Ok(text)
    }

    fn push(&mut self, value: Value) -> Result<(), ConvertError> {
        if self.values.len() >= MAX_VALUES {
            return Err(self.error(format!("more than {MAX_VALUES} values")));
        }
        self.stack.push(self.values.len());
        self.values.push(value);
        Ok(())
    }

    fn pop(&mut self) -> Result<Id, ConvertError> {
        let floor = self.marks.last().copied().unwrap_or(0);
        let found = if self.stack.len() > floor { self.stack.pop() } else { None };
        found.ok_or_else(|| self.error("a value is wanted where there is none"))
    }

    fn since_mark(&mut self) -> Result<Vec<Id>, ConvertError> {
        let mark = self.marks.pop().ok_or_else(|| self.error("no mark to go back to"))?;
        Ok(self.stack.split_off(mark))
    }

    fn step(&mut self, op: u8) -> Result<(), ConvertError> {
        match op {
            0x80 => self.take(1).map(drop),
            0x95 => self.take(8).map(drop),
            b'(' => {
                self.marks.push(self.stack.len());
                Ok(())
            }
            b'N' | 0x88 | 0x89 => self.push(Value::Plain),
            b'G' => self.take(8).and_then(|_| self.push(Value::Plain)),
            b'K' | b'M' | b'J' | 0x8a => self.integer(op),
            b'X' | 0x8c => self.string(op),
            b'}' => self.push(Value::Dict(vec![])),
            b']' | b')' => self.push(Value::Sequence(vec![])),
            b't' | 0x85..=0x87 => self.tuple(op),
            b's' | b'u' => self.set_items(op),
            b'a' | b'e' => self.append(op),
            b'q' | b'r' | 0x94 | b'h' | b'j' => self.remember(op),
            b'c' | 0x93 => self.name(op),
            b'Q' => self.persistent(),
            b'R' | 0x81 => self.call(),
            b'b' => self.build(),
            other => Err(self.error(format!("instruction 0x{other:02x} is not one tensors need"))),
        }
    }

    fn integer(&mut self, op: u8) -> Result<(), ConvertError> {
        let value = match op {
            b'K' => i64::from(self.take(1)?[0]),
            b'M' => i64::from(u16::from_le_bytes(self.number()?)),
            b'J' => i64::from(i32::from_le_bytes(self.number()?)),
            _ => {
                let length = usize::from(self.take(1)?[0]);
                let bytes = self.take(length)?;
                let negative = bytes.last().is_some_and(|b| b & 0x80 != 0);
                let mut wide = [if negative { 0xff } else { 0 }; 8];
                let room = wide.get_mut(..length);
                room.ok_or_else(|| self.error("an integer of more than 64 bits"))?
                    .copy_from_slice(bytes);
                i64::from_le_bytes(wide)
            }
        };
        self.push(Value::Int(value))
    }

    fn string(&mut self, op: u8) -> Result<(), ConvertError> {
        let length = match op {
            b'X' => u32::from_le_bytes(self.number()?) as usize,
            _ => usize::from(self.take(1)?[0]),
        };
        let text = self.text(length)?;
        self.push(Value::Text(text))
    }

    fn tuple(&mut self, op: u8) -> Result<(), ConvertError> {
        let items = match op {
            b't' => self.since_mark()?,
            _ => {
                let mut items = Vec::new();
                for _ in 0x84..op {
                    items.insert(0, self.pop()?);
                }
                items
            }
        };
        self.push(Value::Sequence(items))
    }

    /// The value on top of the stack, to be changed in place.
    fn top(&mut self) -> Result<&mut Value, ConvertError> {
        let id = self.stack.last().copied();
        let missing = self.error("a value is wanted where there is none");
        id.and_then(|id| self.values.get_mut(id)).ok_or(missing)
    }

    fn set_items(&mut self, op: u8) -> Result<(), ConvertError> {
        let items = match op {
            b'u' => self.since_mark()?,
            _ => {
                let value = self.pop()?;
                vec![self.pop()?, value]
            }
        };
        let wrong = self.error("items are set on something that is no dictionary");
        match self.top()? {
            Value::Dict(all) => {
                all.extend(items.as_chunks::<2>().0.iter().map(|&[k, v]| (k, v)));
                Ok(())
            }
            Value::Foreign(_) => Ok(()),
            _ => Err(wrong),
        }
    }

    fn append(&mut self, op: u8) -> Result<(), ConvertError> {
        let items = if op == b'e' { self.since_mark()? } else { vec![self.pop()?] };
        let wrong = self.error("items are added to something that is no list");
        match self.top()? {
            Value::Sequence(all) => {
                all.extend(items);
                Ok(())
            }
            Value::Foreign(_) => Ok(()),
            _ => Err(wrong),
        }
    }

    fn remember(&mut self, op: u8) -> Result<(), ConvertError> {
        let key = match op {
            b'q' | b'h' => u32::from(self.take(1)?[0]),
            b'r' | b'j' => u32::from_le_bytes(self.number()?),
            _ => self.memo.len() as u32,
        };
        if matches!(op, b'h' | b'j') {
            let id = self.memo.get(&key).copied();
            self.stack.push(id.ok_or_else(|| self.error(format!("memo {key} was never set")))?);
            return Ok(());
        }
        let id = self.stack.last().copied();
        let id = id.ok_or_else(|| self.error("nothing to remember"))?;
        self.memo.insert(key, id);
        Ok(())
    }

    fn name(&mut self, op: u8) -> Result<(), ConvertError> {
        let (module, name) = if op == b'c' {
            (self.line()?, self.line()?)
        } else {
            let (name, module) = (self.pop()?, self.pop()?);
            match (self.values.get(module), self.values.get(name)) {
                (Some(Value::Text(m)), Some(Value::Text(n))) => (m.clone(), n.clone()),
                _ => return Err(self.error("a name that is no text")),
            }
        };
        let full = format!("{module}.{name}");
        match (known(&full), self.foreign) {
            (Some(known), _) => self.push(Value::Name(known)),
            (None, Foreign::Opaque) => self.push(Value::Foreign(full)),
            (None, Foreign::Refused) => Err(ConvertError::Foreign(full)),
        }
    }

    fn sequence(&self, id: Id) -> Option<&[Id]> {
        match self.values.get(id)? {
            Value::Sequence(items) => Some(items),
            _ => None,
        }
    }

    fn count(&self, id: Id) -> Option<usize> {
        match self.values.get(id)? {
            Value::Int(n) => usize::try_from(*n).ok(),
            _ => None,
        }
    }

    /// ('storage', type, key, device, count)
    fn persistent(&mut self) -> Result<(), ConvertError> {
        let id = self.pop()?;
        let storage = || {
            let items = self.sequence(id)?;
            let get = |i: usize| items.get(i).and_then(|&i| self.values.get(i));
            let (Value::Text(kind), Value::Name(Known::Storage(dtype)), Value::Text(key)) =
                (get(0)?, get(1)?, get(2)?)
            else {
                return None;
            };
            let count = self.count(*items.get(4)?)?;
            (kind == "storage").then(|| Storage { key: key.clone(), dtype: *dtype, count })
        };
        let storage = storage().ok_or_else(|| self.error("a reference that is no storage"))?;
        self.push(Value::Storage(storage))
    }

    /// What a known name makes of its arguments; a foreign one gives a foreign value.
    fn call(&mut self) -> Result<(), ConvertError> {
        let (arguments, name) = (self.pop()?, self.pop()?);
        let value = match self.values.get(name) {
            Some(Value::Foreign(name)) => Some(Value::Foreign(name.clone())),
            Some(Value::Name(Known::OrderedDict)) => {
                let empty = self.sequence(arguments).is_some_and(<[Id]>::is_empty);
                empty.then(|| Value::Dict(vec![]))
            }
            Some(Value::Name(Known::Tensor)) => self.tensor(arguments).map(Value::Tensor),
            Some(Value::Name(Known::Parameter)) => {
                let first = self.sequence(arguments).and_then(|a| a.first());
                let inner = first.and_then(|&id| self.values.get(id));
                inner.filter(|v| matches!(v, Value::Tensor(_))).cloned()
            }
            _ => None,
        };
        let value =
            value.ok_or_else(|| self.error("a call whose name and arguments do not fit"))?;
        self.push(value)
    }

    /// (storage, offset, shape, strides, ..), proved to stay inside the storage.
    fn tensor(&self, arguments: Id) -> Option<TensorAt> {
        let items = self.sequence(arguments)?;
        let Value::Storage(storage) = self.values.get(*items.first()?)? else { return None };
        let offset = self.count(*items.get(1)?)?;
        let numbers = |id: Id| {
            self.sequence(id)?.iter().map(|&i| self.count(i)).collect::<Option<Vec<usize>>>()
        };
        let (shape, strides): (Vec<usize>, Vec<usize>) =
            (numbers(*items.get(2)?)?, numbers(*items.get(3)?)?);
        let size = shape.iter().try_fold(1usize, |n, &s| n.checked_mul(s))?;
        let reach = shape.iter().zip(&strides).try_fold(offset, |at, (&n, &stride)| {
            at.checked_add(n.saturating_sub(1).checked_mul(stride)?)
        })?;
        let inside = size == 0 || (reach < storage.count && size <= storage.count);
        let sound = shape.len() == strides.len() && shape.len() <= 8 && inside;
        sound.then(|| TensorAt { storage: storage.clone(), offset, shape, strides })
    }

    /// State given to an object: dictionaries carry a note PyTorch calls `_metadata`, which is
    /// dropped; foreign objects stay opaque.
    fn build(&mut self) -> Result<(), ConvertError> {
        self.pop()?;
        let wrong = self.error("state is given to something that has none");
        match self.top()? {
            Value::Dict(_) | Value::Foreign(_) => Ok(()),
            _ => Err(wrong),
        }
    }
}

fn known(name: &str) -> Option<Known> {
    let storage = |dtype| Some(Known::Storage(dtype));
    match name {
        "collections.OrderedDict" => Some(Known::OrderedDict),
        "torch._utils._rebuild_tensor_v2" => Some(Known::Tensor),
        "torch._utils._rebuild_parameter" => Some(Known::Parameter),
        "torch.FloatStorage" => storage(Dtype::F32),
        "torch.DoubleStorage" => storage(Dtype::F64),
        "torch.HalfStorage" => storage(Dtype::F16),
        "torch.BFloat16Storage" => storage(Dtype::BF16),
        "torch.LongStorage" => storage(Dtype::I64),
        "torch.IntStorage" => storage(Dtype::I32),
        "torch.ShortStorage" => storage(Dtype::I16),
        "torch.CharStorage" => storage(Dtype::I8),
        "torch.ByteStorage" => storage(Dtype::U8),
        "torch.BoolStorage" => storage(Dtype::BOOL),
        _ => None,
    }
}
