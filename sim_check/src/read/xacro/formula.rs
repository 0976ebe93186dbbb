//! Expressions of xacro: arithmetic, comparisons, texts and a list of functions. What is not listed
//! here is refused; nothing of Python is run.

use std::f64::consts::{E, PI, TAU};

use super::value::Value;

/// Deepest nesting of an expression, and its most characters.
const DEEPEST: usize = 48;
const LONGEST: usize = 4096;

/// A name's value, or why it has none.
pub(super) type Lookup<'l> = &'l mut dyn FnMut(&str) -> Result<Value, String>;

/// Works an expression out.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn work_out(text: &str, names: Lookup) -> Result<Value, String> {
    if text.len() > LONGEST {
        return Err(format!("an expression has at most {LONGEST} characters"));
    }
    let tokens = tokens(text)?;
    let mut parser = Parser { tokens: &tokens, at: 0, depth: 0, names };
    let value = parser.choice()?;
    match parser.tokens.get(parser.at) {
        None => Ok(value),
        Some(token) => Err(format!("{} is not expected here", token.shown())),
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Token {
    Value(Value),
    Word(String),
    Sign(&'static str),
}

impl Token {
    fn shown(&self) -> String {
        match self {
            Self::Value(value) => format!("`{}`", value.shown()),
            Self::Word(word) => format!("`{word}`"),
            Self::Sign(sign) => format!("`{sign}`"),
        }
    }
}

const SIGNS: [&str; 23] = [
    "**", "//", "==", "!=", "<=", ">=", "+", "-", "*", "/", "%", "<", ">", "(", ")", "[", "]", ",",
    ".", ":", "{", "}", "=",
];

fn tokens(text: &str) -> Result<Vec<Token>, String> {
    let (mut found, mut rest) = (Vec::new(), text.trim_start());
    while let Some(first) = rest.chars().next() {
        let (token, used) = match first {
            '"' | '\'' => {
                let end = rest[1..].find(first).ok_or("a text that does not end")?;
                (Token::Value(Value::Text(rest[1..=end].to_owned())), end + 2)
            }
            c if c.is_ascii_digit() || c == '.' && starts_digit(&rest[1..]) => number(rest)?,
            c if c.is_alphabetic() || c == '_' => {
                let is_part = |c: char| c.is_alphanumeric() || c == '_';
                let end = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
                (Token::Word(rest[..end].to_owned()), end)
            }
            other => {
                let sign = SIGNS.into_iter().find(|sign| rest.starts_with(sign));
                let sign = sign.ok_or_else(|| format!("`{other}` means nothing here"))?;
                (Token::Sign(sign), sign.len())
            }
        };
        found.push(token);
        rest = rest[used..].trim_start();
    }
    Ok(found)
}

fn starts_digit(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_digit())
}

fn number(text: &str) -> Result<(Token, usize), String> {
    let bytes = text.as_bytes();
    let mut end = 0;
    while let Some(b) = bytes.get(end) {
        let after_e = end > 0 && matches!(bytes[end - 1], b'e' | b'E');
        let goes_on = b.is_ascii_digit()
            || matches!(b, b'.' | b'e' | b'E')
            || after_e && matches!(b, b'+' | b'-');
        if !goes_on {
            break;
        }
        end += 1;
    }
    let word = &text[..end];
    match Value::of(word) {
        Value::Text(_) => Err(format!("`{word}` is not a number")),
        value => Ok((Token::Value(value), end)),
    }
}

struct Parser<'t, 'l> {
    tokens: &'t [Token],
    at: usize,
    depth: usize,
    names: Lookup<'l>,
}

type Worked = Result<Value, String>;

impl Parser<'_, '_> {
    fn sign(&mut self, sign: &str) -> bool {
        let is_it = matches!(self.tokens.get(self.at), Some(Token::Sign(s)) if *s == sign);
        self.at += usize::from(is_it);
        is_it
    }

    fn word(&mut self, word: &str) -> bool {
        let is_it = matches!(self.tokens.get(self.at), Some(Token::Word(w)) if w == word);
        self.at += usize::from(is_it);
        is_it
    }

    fn expect(&mut self, sign: &str) -> Result<(), String> {
        if self.sign(sign) { Ok(()) } else { Err(format!("`{sign}` is missing")) }
    }

    /// `a if c else b`.
    fn choice(&mut self) -> Worked {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("an expression nests at most {DEEPEST} deep"));
        }
        let value = self.either()?;
        let chosen = if self.word("if") {
            let condition = self.either()?;
            if !self.word("else") {
                return Err("`else` is missing".into());
            }
            let other = self.choice()?;
            if condition.is_true() { value } else { other }
        } else {
            value
        };
        self.depth -= 1;
        Ok(chosen)
    }

    fn either(&mut self) -> Worked {
        let mut value = self.both()?;
        while self.word("or") {
            let next = self.both()?;
            value = if value.is_true() { value } else { next };
        }
        Ok(value)
    }

    fn both(&mut self) -> Worked {
        let mut value = self.not()?;
        while self.word("and") {
            let next = self.not()?;
            value = if value.is_true() { next } else { value };
        }
        Ok(value)
    }

    fn not(&mut self) -> Worked {
        let mut turns = 0;
        while self.word("not") {
            turns += 1;
        }
        let value = self.compared()?;
        match turns {
            0 => Ok(value),
            turns => Ok(Value::Bool(value.is_true() != (turns % 2 == 1))),
        }
    }

    fn compared(&mut self) -> Worked {
        let left = self.sum()?;
        for sign in ["==", "!=", "<=", ">=", "<", ">"] {
            if self.sign(sign) {
                let right = self.sum()?;
                return compare(sign, &left, &right).map(Value::Bool);
            }
        }
        let turned = self.word("not");
        if self.word("in") {
            let right = self.sum()?;
            let is_in = match (&left, &right) {
                (left, Value::List(all)) => all.iter().any(|v| same(v, left)),
                (Value::Text(part), Value::Text(whole)) => whole.contains(part.as_str()),
                _ => return Err("`in` wants a list or a text".into()),
            };
            return Ok(Value::Bool(is_in != turned));
        }
        if turned { Err("`in` is missing".into()) } else { Ok(left) }
    }

    fn sum(&mut self) -> Worked {
        let mut value = self.product()?;
        loop {
            let sign = match () {
                () if self.sign("+") => "+",
                () if self.sign("-") => "-",
                () => return Ok(value),
            };
            let right = self.product()?;
            value = match (sign, value, right) {
                ("+", Value::Text(a), Value::Text(b)) => Value::Text(a + &b),
                ("+", Value::List(a), Value::List(b)) => Value::List([a, b].concat()),
                (sign, a, b) => calculate(sign, &a, &b)?,
            };
        }
    }

    fn product(&mut self) -> Worked {
        let mut value = self.signed()?;
        loop {
            let found = ["*", "//", "/", "%"].into_iter().find(|sign| self.sign(sign));
            let Some(sign) = found else { return Ok(value) };
            let right = self.signed()?;
            value = calculate(sign, &value, &right)?;
        }
    }

    fn signed(&mut self) -> Worked {
        let mut minus = false;
        loop {
            match () {
                () if self.sign("-") => minus = !minus,
                () if self.sign("+") => {}
                () => break,
            }
        }
        let value = self.power()?;
        match (minus, value) {
            (false, value) => Ok(value),
            (true, Value::Int(n)) => n.checked_neg().map(Value::Int).ok_or("too large".into()),
            (true, value) => {
                let number = value.number().ok_or("only numbers have a sign")?;
                Ok(Value::Float(-number))
            }
        }
    }

    fn power(&mut self) -> Worked {
        let base = self.part()?;
        if !self.sign("**") {
            return Ok(base);
        }
        let exponent = self.signed()?;
        calculate("**", &base, &exponent)
    }

    /// A value with what is taken of it: `a[1]`, `a.b`, `a['b']`.
    fn part(&mut self) -> Worked {
        let mut value = self.atom()?;
        loop {
            if self.sign("[") {
                let key = self.choice()?;
                self.expect("]")?;
                value = taken(&value, &key)?;
            } else if self.sign(".") {
                let Some(Token::Word(name)) = self.tokens.get(self.at).cloned() else {
                    return Err("a name is missing after the dot".into());
                };
                self.at += 1;
                value = taken(&value, &Value::Text(name))?;
            } else {
                return Ok(value);
            }
        }
    }

    fn atom(&mut self) -> Worked {
        let token = self.tokens.get(self.at).cloned().ok_or("it breaks off")?;
        self.at += 1;
        match token {
            Token::Value(value) => Ok(value),
            Token::Sign("(") => {
                let value = self.choice()?;
                self.expect(")")?;
                Ok(value)
            }
            Token::Sign("[") => self.several("]").map(Value::List),
            Token::Word(name) => self.named(&name),
            other => Err(format!("{} is not expected here", other.shown())),
        }
    }

    /// Values up to a sign, with commas between.
    fn several(&mut self, end: &str) -> Result<Vec<Value>, String> {
        let mut all = Vec::new();
        while !self.sign(end) {
            if !all.is_empty() {
                self.expect(",")?;
                if self.sign(end) {
                    break;
                }
            }
            all.push(self.choice()?);
        }
        Ok(all)
    }

    fn named(&mut self, name: &str) -> Worked {
        match name {
            "True" | "true" => return Ok(Value::Bool(true)),
            "False" | "false" => return Ok(Value::Bool(false)),
            _ => {}
        }
        let module = matches!(name, "math" | "python" | "xacro" | "numpy");
        if module && self.sign(".") {
            let Some(Token::Word(inner)) = self.tokens.get(self.at).cloned() else {
                return Err(format!("a name is missing after `{name}.`"));
            };
            self.at += 1;
            return self.named(&inner);
        }
        if self.sign("(") {
            let of = self.several(")")?;
            return call(name, &of);
        }
        let constant = match name {
            "pi" => Some(PI),
            "tau" => Some(TAU),
            "e" => Some(E),
            _ => None,
        };
        match ((self.names)(name), constant) {
            (Ok(value), _) => Ok(value),
            (Err(_), Some(value)) => Ok(Value::Float(value)),
            (Err(why), None) => Err(why),
        }
    }
}

fn same(a: &Value, b: &Value) -> bool {
    match (a.number(), b.number()) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    }
}

fn compare(sign: &str, a: &Value, b: &Value) -> Result<bool, String> {
    match sign {
        "==" => return Ok(same(a, b)),
        "!=" => return Ok(!same(a, b)),
        _ => {}
    }
    let order = match (a, b) {
        (Value::Text(a), Value::Text(b)) => Some(a.cmp(b)),
        _ => a.number().zip(b.number()).and_then(|(a, b)| a.partial_cmp(&b)),
    };
    let order = order.ok_or_else(|| format!("`{sign}` wants two numbers or two texts"))?;
    Ok(match sign {
        "<" => order.is_lt(),
        "<=" => order.is_le(),
        ">" => order.is_gt(),
        _ => order.is_ge(),
    })
}

fn calculate(sign: &str, a: &Value, b: &Value) -> Worked {
    let is_whole = |v: &Value| matches!(v, Value::Int(_) | Value::Bool(_));
    let numbers = a.number().zip(b.number());
    let (x, y) = numbers.ok_or_else(|| format!("`{sign}` wants numbers"))?;
    if matches!(sign, "/" | "//" | "%") && y == 0.0 {
        return Err("a division by nought".into());
    }
    let result = match sign {
        "+" => x + y,
        "-" => x - y,
        "*" => x * y,
        "/" => x / y,
        "//" => (x / y).floor(),
        "%" => x - y * (x / y).floor(),
        _ => x.powf(y),
    };
    if !result.is_finite() {
        return Err(format!("`{sign}` comes to no finite number"));
    }
    // Whole numbers stay whole, as far as a float holds them.
    let stays = sign != "/" && is_whole(a) && is_whole(b) && result.abs() < 9e15;
    let stays = stays && (sign != "**" || y >= 0.0);
    Ok(if stays { Value::Int(result as i64) } else { Value::Float(result) })
}

fn taken(value: &Value, key: &Value) -> Worked {
    let missing = || format!("there is no `{}` in it", key.shown());
    match (value, key) {
        (Value::List(all), Value::Int(index)) => {
            let index = if *index < 0 { index + all.len() as i64 } else { *index };
            let found = usize::try_from(index).ok().and_then(|i| all.get(i));
            found.cloned().ok_or_else(missing)
        }
        _ => Err(missing()),
    }
}

fn call(name: &str, of: &[Value]) -> Worked {
    let wrong = || format!("`{name}` is not called so");
    let numbers: Option<Vec<f64>> = of.iter().map(Value::number).collect();
    if let (Some(numbers), Some(made)) = (&numbers, numbers.as_deref().and_then(|n| maths(name, n)))
    {
        let whole =
            matches!(name, "abs" | "min" | "max") && of.iter().all(|v| matches!(v, Value::Int(_)));
        let rounds =
            matches!(name, "int" | "floor" | "ceil") || name == "round" && numbers.len() == 1;
        if !made.is_finite() {
            return Err(format!("`{name}` comes to no finite number"));
        }
        return Ok(if whole || rounds { Value::Int(made as i64) } else { Value::Float(made) });
    }
    match (name, of) {
        ("str", [value]) => Ok(Value::Text(value.shown())),
        ("bool", [value]) => Ok(Value::Bool(value.is_true())),
        ("float" | "int", [Value::Text(text)]) => {
            let number = Value::of(text).number().ok_or_else(wrong)?;
            call(name, &[Value::Float(number)])
        }
        ("len", [Value::List(all)]) => Ok(Value::Int(all.len() as i64)),
        ("len", [Value::Text(text)]) => Ok(Value::Int(text.chars().count() as i64)),
        ("min" | "max", [Value::List(all)]) => call(name, all),
        ("list", [Value::List(all)]) => Ok(Value::List(all.clone())),
        _ => Err(format!("the function `{name}` is not known here, or not with these values")),
    }
}

fn maths(name: &str, numbers: &[f64]) -> Option<f64> {
    Some(match (name, numbers) {
        ("sin", [x]) => x.sin(),
        ("cos", [x]) => x.cos(),
        ("tan", [x]) => x.tan(),
        ("asin", [x]) => x.asin(),
        ("acos", [x]) => x.acos(),
        ("atan", [x]) => x.atan(),
        ("atan2", [y, x]) => y.atan2(*x),
        ("sqrt", [x]) => x.sqrt(),
        ("radians", [x]) => x.to_radians(),
        ("degrees", [x]) => x.to_degrees(),
        ("abs" | "fabs", [x]) => x.abs(),
        ("exp", [x]) => x.exp(),
        ("log", [x]) => x.ln(),
        ("hypot", [x, y]) => x.hypot(*y),
        ("pow", [x, y]) => x.powf(*y),
        ("floor", [x]) => x.floor(),
        ("ceil", [x]) => x.ceil(),
        ("int", [x]) => x.trunc(),
        ("float", [x]) => *x,
        ("round", [x]) => x.round_ties_even(),
        ("round", [x, digits]) => {
            let scale = 10f64.powf(digits.trunc().clamp(-15.0, 15.0));
            (x * scale).round_ties_even() / scale
        }
        ("min", [first, rest @ ..]) => rest.iter().copied().fold(*first, f64::min),
        ("max", [first, rest @ ..]) => rest.iter().copied().fold(*first, f64::max),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worked(text: &str) -> Result<String, String> {
        let mut names = |name: &str| match name {
            "width" => Ok(Value::Float(0.4)),
            "n" => Ok(Value::Int(3)),
            "side" => Ok(Value::Text("left".into())),
            "at" => Ok(Value::List(vec![Value::Int(1), Value::Float(2.5)])),
            other => Err(format!("`{other}` is not known")),
        };
        work_out(text, &mut names).map(|v| v.shown())
    }

    #[test]
    fn arithmetic_is_that_of_python() {
        for (text, due) in [
            ("1 + 2*3", "7"),
            ("7/2", "3.5"),
            ("7//2", "3"),
            ("-7 // 2", "-4"),
            ("-7 % 3", "2"),
            ("2**-1", "0.5"),
            ("-2**2", "-4"),
            ("width/2 - 0.1", "0.1"),
            ("1e-3 * n", "0.003"),
            ("radians(180) == pi", "True"),
            ("round(2.567, 1)", "2.6"),
            ("max(1, n, 2)", "3"),
            ("sqrt(16) if n > 2 else 0", "4.0"),
            ("side == 'left' and not n < 2", "True"),
            ("'f' + side", "fleft"),
            ("at[1] + at[-1]", "5.0"),
            ("side in ['left', 'right']", "True"),
            ("math.cos(0.0)", "1.0"),
            ("str(n) + '_x'", "3_x"),
        ] {
            assert_eq!(worked(text).as_deref(), Ok(due), "{text}");
        }
    }

    #[test]
    fn what_is_not_listed_is_refused_and_ends() {
        for text in [
            "__import__('os')",
            "().__class__",
            "open('x')",
            "1/0",
            "unknown",
            "1 +",
            "'x",
            "lambda: 1",
            "9**9**9",
            "a.b.c",
            "1 2",
            "@",
        ] {
            assert!(worked(text).is_err(), "{text}: {:?}", worked(text));
        }
        assert!(worked(&"(".repeat(1000)).is_err());
        assert!(worked(&"1+".repeat(5000)).is_err());
        assert!(worked(&format!("{}1", "-".repeat(2000))).is_ok());
    }
}
