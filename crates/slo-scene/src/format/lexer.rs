//! Scene text -> words and braces.

use std::ops::Range;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TokenKind {
    /// A run of characters without white space or braces, or a name in double quotes, with them.
    Word,
    /// `{`
    Open,
    /// `}`
    Close,
    /// A `/*` without its `*/`; the rest of the text is lost.
    UnclosedComment,
    /// Nothing is left.
    End,
}

/// A token and its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: TokenKind,
    pub(crate) range: Range<usize>,
}

/// Reads tokens off a text. White space is Unicode's; a comment starts where a token could.
#[derive(Clone, Debug)]
pub(crate) struct Lexer<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Lexer<'a> {
    pub(crate) fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    /// Continues at a byte that was passed, or at the next.
    pub(crate) fn rewind(&mut self, at: usize) {
        self.at = at;
    }

    /// The next token; [`TokenKind::End`] again and again at the end.
    pub(crate) fn next_token(&mut self) -> Token {
        loop {
            let rest = self.skip_white_space();
            if rest.starts_with('#') {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if let Some(comment) = rest.strip_prefix("/*") {
                match comment.find("*/") {
                    Some(length) => self.at += length + 4,
                    None => return self.unclosed_comment(),
                }
            } else {
                return self.token(rest);
            }
        }
    }

    fn skip_white_space(&mut self) -> &'a str {
        let rest = self.text[self.at..].trim_start();
        self.at = self.text.len() - rest.len();
        rest
    }

    fn unclosed_comment(&mut self) -> Token {
        let range = self.at..self.at + 2;
        self.at = self.text.len();
        Token { kind: TokenKind::UnclosedComment, range }
    }

    fn token(&mut self, rest: &str) -> Token {
        let (kind, length) = match rest.bytes().next() {
            None => (TokenKind::End, 0),
            Some(b'{') => (TokenKind::Open, 1),
            Some(b'}') => (TokenKind::Close, 1),
            Some(b'"') => (TokenKind::Word, quoted_length(rest)),
            Some(_) => (TokenKind::Word, word_length(rest)),
        };
        let range = self.at..self.at + length;
        self.at = range.end;
        Token { kind, range }
    }
}

/// The bytes of a name in quotes, which ends in its line; otherwise those of a plain word.
fn quoted_length(rest: &str) -> usize {
    let line = &rest[..rest.find(['\n', '\r']).unwrap_or(rest.len())];
    match line[1..].find('"') {
        Some(length) => length + 2,
        None => word_length(rest),
    }
}

fn word_length(rest: &str) -> usize {
    rest.find(|c: char| c.is_whitespace() || c == '{' || c == '}').unwrap_or(rest.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expected: &[&str]) {
        let mut lexer = Lexer::new(text);
        let mut tokens = Vec::new();
        loop {
            let token = lexer.next_token();
            match token.kind {
                TokenKind::End => break,
                TokenKind::UnclosedComment => tokens.push("unclosed"),
                _ => tokens.push(&text[token.range]),
            }
        }
        assert_eq!(tokens, expected, "{text:?}");
    }

    #[test]
    fn words_and_braces() {
        check("a b{c}d { } ", &["a", "b", "{", "c", "}", "d", "{", "}"]);
        check("plošné_světlo\u{a0}s\r\n{1\t2}", &["plošné_světlo", "s", "{", "1", "2", "}"]);
        check("", &[]);
    }

    #[test]
    fn names_in_quotes() {
        check("a \"b {c} # d\" e", &["a", "\"b {c} # d\"", "e"]);
        check("a\"b\" \"\"{\"c\"d}", &["a\"b\"", "\"\"", "{", "\"c\"", "d", "}"]);
        check("\"a b\nc\" d\"", &["\"a", "b", "c\"", "d\""]);
        check("\"a b\r\nc\"", &["\"a", "b", "c\""]);
    }

    #[test]
    fn comments() {
        check("a # b { c\nd", &["a", "d"]);
        check("a /* b\n { /* */ c", &["a", "c"]);
        check("{#x\n}/*y*/b", &["{", "}", "b"]);
        check("a /*/ b", &["a", "unclosed"]);
        check("a /**/ b#c d/*e*/", &["a", "b#c", "d/*e*/"]);
        check("# only", &[]);
    }
}
