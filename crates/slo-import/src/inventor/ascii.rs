//! The text flavour. Fields are read by what their values look like, so nodes of unknown classes can be
//! read as well.

use std::collections::HashMap;
use std::rc::Rc;
use std::str::FromStr;

use super::DEEPEST;
use super::tree::{Node, Value};
use crate::error::ImportError;
use crate::files::Source;
use crate::model::Notes;
use crate::words::shortened;

/// Reads the nodes of a file whose text this is.
pub(super) fn read(
    source: &Source,
    text: &str,
    notes: &mut Notes,
) -> Result<Vec<Rc<Node>>, ImportError> {
    let tokens = Tokens { rest: text, line: 1 };
    let mut reader = Reader { source, tokens, ahead: None, names: HashMap::new(), notes, depth: 0 };
    let mut nodes = Vec::new();
    while let Some(token) = reader.next() {
        let Token::Word(word) = token else {
            return reader.bad("expected a node");
        };
        nodes.extend(reader.node_named(word)?);
    }
    Ok(nodes)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'a> {
    /// One of `{ } [ ] ( ) | ~ =`
    Mark(char),
    Word(&'a str),
    Text(&'a str),
}

struct Tokens<'a> {
    rest: &'a str,
    /// The current line, from 1.
    line: usize,
}

impl<'a> Iterator for Tokens<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        loop {
            let first = self.rest.chars().next()?;
            match first {
                '#' => self.take(self.rest.find(['\n', '\r']).unwrap_or(self.rest.len())),
                _ if first.is_whitespace() || first == ',' => self.take(first.len_utf8()),
                '{' | '}' | '[' | ']' | '(' | ')' | '|' | '~' | '=' => {
                    self.take(1);
                    return Some(Token::Mark(first));
                }
                '"' => return Some(Token::Text(self.text())),
                _ => {
                    let is_end = |c: char| c.is_whitespace() || "{}[]()|~=,\"#".contains(c);
                    let end = self.rest.find(is_end).unwrap_or(self.rest.len());
                    return Some(Token::Word(self.take(end)));
                }
            };
        }
    }
}

impl<'a> Tokens<'a> {
    fn take(&mut self, length: usize) -> &'a str {
        let (taken, rest) = self.rest.split_at(length);
        self.line += taken.bytes().filter(|&byte| byte == b'\n').count();
        self.rest = rest;
        taken
    }

    /// What stands in quotes, or up to the end if they are not closed.
    fn text(&mut self) -> &'a str {
        self.take(1);
        let mut is_escaped = false;
        let is_end = |(_, c): &(usize, char)| {
            let is_end = *c == '"' && !is_escaped;
            is_escaped = *c == '\\' && !is_escaped;
            is_end
        };
        let end = self.rest.char_indices().find(is_end).map(|(i, _)| i);
        let text = self.take(end.unwrap_or(self.rest.len()));
        self.take(usize::from(end.is_some()));
        text
    }
}

struct Reader<'a> {
    source: &'a Source,
    tokens: Tokens<'a>,
    ahead: Option<Token<'a>>,
    /// Nodes by the names that they have so far.
    names: HashMap<String, Rc<Node>>,
    notes: &'a mut Notes,
    depth: usize,
}

impl<'a> Reader<'a> {
    fn bad<T>(&self, message: impl Into<String>) -> Result<T, ImportError> {
        Err(self.source.bad_line(self.tokens.line, message))
    }

    fn next(&mut self) -> Option<Token<'a>> {
        self.ahead.take().or_else(|| self.tokens.next())
    }

    fn peek(&mut self) -> Option<Token<'a>> {
        self.ahead = self.next();
        self.ahead
    }

    fn takes(&mut self, mark: char) -> bool {
        let is_next = self.peek() == Some(Token::Mark(mark));
        if is_next {
            self.ahead = None;
        }
        is_next
    }

    fn word(&mut self, of: &str) -> Result<&'a str, ImportError> {
        match self.next() {
            Some(Token::Word(word)) => Ok(word),
            Some(_) => self.bad(format!("expected {of}")),
            None => self.bad(format!("{of} is missing at the end")),
        }
    }

    /// A node that begins with this word; `None` if there is none of the name that it uses.
    fn node_named(&mut self, word: &str) -> Result<Option<Rc<Node>>, ImportError> {
        match word {
            "NULL" => Ok(None),
            "USE" => {
                let name = self.word("the name of a node")?;
                let node = self.names.get(name).cloned();
                if node.is_none() {
                    self.notes.leave_out(format!(
                        "what is called `{}`, which no node is",
                        shortened(name)
                    ));
                }
                Ok(node)
            }
            "DEF" => {
                let name = self.word("the name of a node")?;
                let class = self.word("a class")?;
                let node = Rc::new(Node { name: Some(name.into()), ..self.node(class)? });
                self.names.insert(name.into(), Rc::clone(&node));
                Ok(Some(node))
            }
            class => Ok(Some(Rc::new(self.node(class)?))),
        }
    }

    /// The braces of a node with what stands in them.
    fn node(&mut self, class: &str) -> Result<Node, ImportError> {
        if !self.takes('{') {
            return self.bad(format!("expected `{{` behind `{}`", shortened(class)));
        }
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.bad(format!("nodes are nested more than {DEEPEST} deep"));
        }
        let mut node = Node { class: class.into(), ..Node::default() };
        loop {
            let word = match self.next() {
                Some(Token::Mark('}')) => break,
                Some(Token::Word(word)) => word,
                Some(_) => {
                    return self
                        .bad(format!("expected a field or a node in `{}`", shortened(class)));
                }
                None => {
                    return self.bad(format!("`{}` is not closed at the end", shortened(class)));
                }
            };
            if matches!(word, "DEF" | "USE" | "NULL") || self.peek() == Some(Token::Mark('{')) {
                node.children.extend(self.node_named(word)?);
            } else if let Some(value) = self.value()? {
                node.fields.push((word.into(), value));
            }
        }
        self.depth -= 1;
        Ok(node)
    }

    /// The value of a field; `None` if the file says that it does not count.
    fn value(&mut self) -> Result<Option<Value>, ImportError> {
        let mut value = match self.peek() {
            Some(Token::Mark('[')) => Some(self.list(']')?),
            Some(Token::Mark('(')) => Some(self.list(')')?),
            Some(Token::Mark('~' | '=')) => None,
            Some(Token::Text(text)) => {
                self.ahead = None;
                Some(Value::Words(vec![unescaped(text)]))
            }
            Some(Token::Word(word)) if number(word).is_some() => {
                let mut numbers = Vec::new();
                while let Some(Token::Word(word)) = self.peek()
                    && let Some(number) = number(word)
                {
                    self.ahead = None;
                    numbers.push(number);
                }
                Some(Value::Numbers(numbers))
            }
            Some(Token::Word(word)) => {
                self.ahead = None;
                let is_node =
                    matches!(word, "DEF" | "USE" | "NULL") || self.peek() == Some(Token::Mark('{'));
                if is_node {
                    self.node_named(word)?.map(Value::Node)
                } else {
                    Some(Value::Words(vec![word.into()]))
                }
            }
            _ => return self.bad("a field has no value"),
        };
        if self.takes('~') {
            value = None;
        }
        if self.takes('=') {
            self.word("a field")?;
        }
        Ok(value)
    }

    /// Values up to a closing mark: numbers if there is one, otherwise words.
    fn list(&mut self, end: char) -> Result<Value, ImportError> {
        self.ahead = None;
        let (mut numbers, mut words) = (Vec::new(), Vec::new());
        loop {
            match self.next() {
                Some(Token::Mark(mark)) if mark == end => break,
                Some(Token::Mark('|')) => {}
                Some(Token::Text(text)) => words.push(unescaped(text)),
                Some(Token::Word(word)) => match number(word) {
                    Some(number) => numbers.push(number),
                    None if matches!(word, "DEF" | "USE" | "NULL")
                        || self.peek() == Some(Token::Mark('{')) =>
                    {
                        self.node_named(word)?;
                    }
                    None => words.push(word.into()),
                },
                Some(Token::Mark(mark)) => return self.bad(format!("`{mark}` stands in a list")),
                None => return self.bad("a list is not closed at the end"),
            }
        }
        Ok(if words.is_empty() { Value::Numbers(numbers) } else { Value::Words(words) })
    }
}

fn number(word: &str) -> Option<f64> {
    if let Some(digits) = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X")) {
        return u32::from_str_radix(digits, 16).ok().map(f64::from);
    }
    // Words like `inf` are words.
    let is_number = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    f64::from_str(word).ok().filter(|number| is_number && number.is_finite())
}

fn unescaped(text: &str) -> String {
    text.replace("\\\"", "\"")
}
