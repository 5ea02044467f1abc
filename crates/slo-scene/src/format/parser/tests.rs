//! Texts and their trees.

use super::parse;
use crate::diagnostics::{Diagnostics, Source};
use crate::format::syntax::{Block, Entry, Follows, Form, Grammar, Item};

/// Spheres and cameras with films.
struct Toy;

impl Grammar for Toy {
    fn follows(&self, owner: Option<&str>, word: &str) -> Option<Follows> {
        let follows = match (owner, word) {
            (None, "sphere" | "camera") | (Some("camera"), "film") => Follows::Element,
            (Some("sphere"), "center") => Follows::Vector,
            (Some("sphere"), "material") => Follows::Name,
            (Some("sphere"), "radius") | (Some("camera"), "fps") => Follows::Value,
            (Some("film"), "width") | (Some("key"), "time") => Follows::Value,
            (Some("sphere"), "key") => Follows::Block,
            _ => return None,
        };
        Some(follows)
    }
}

fn outline(entries: &[Entry<'_>]) -> String {
    let one = |entry: &Entry<'_>| match entry {
        Entry::Number(number) => number.value.map_or("?".to_owned(), |v| v.to_string()),
        Entry::Item(Item { keyword, form }) => keyword.text.to_owned() + &form_outline(form),
    };
    entries.iter().map(one).collect::<Vec<_>>().join(" ")
}

fn form_outline(form: &Form<'_>) -> String {
    let block = |block: &Block<'_>| {
        let mark = if block.damaged { "!" } else { "" };
        format!("{{{}}}{mark}", outline(&block.entries))
    };
    match form {
        Form::Element(name, body) => format!(":{}{}", name.text, block(body)),
        Form::Block(body) => block(body),
        Form::Value(word) => format!("={}", word.text),
        Form::Nothing => String::new(),
        Form::Broken => "=!".to_owned(),
    }
}

/// Parses a text; the outline of its tree, and the messages in the order of the text.
fn check(text: &str, expected: &str, errors: &[&str]) {
    let mut diagnostics = Diagnostics::default();
    let source =
        Source { name: String::new(), text: text.into(), first_line: 1, included_at: None };
    let source = diagnostics.add_source(source);
    let tree = parse(text, source, &Toy, &mut diagnostics);
    assert_eq!(outline(&tree.entries), expected, "{text}");
    let messages: Vec<_> = diagnostics.sorted().iter().map(|d| d.message.clone()).collect();
    assert_eq!(messages, errors, "{text}");
}

#[test]
fn three_forms() {
    check(
        "sphere s{center{1 -.5 2e-3}radius 2 material radius}",
        "sphere:s{center{1 -0.5 0.002} radius=2 material=radius}",
        &[],
    );
    check("camera c { film radius { } }", "camera:c{film:radius{}}", &[]);
    check("sphere 1 { } sphere sphere { }", "sphere:1{} sphere:sphere{}", &[]);
    check("", "", &[]);
}

#[test]
fn values_that_are_missing_leave_the_next_attribute_whole() {
    check("sphere s { radius center { 1 } }", "sphere:s{radius center{1}}", &[]);
    check("sphere s { radius material m radius }", "sphere:s{radius material=m radius}", &[]);
    check("sphere s { foo radius 1 }", "sphere:s{foo radius=1}", &[]);
    check("foo\nsphere s { }", "foo sphere:s{}", &[]);
}

const UNCLOSED: &str = "this `{` is never closed";

#[test]
fn a_vector_ends_where_an_attribute_begins() {
    let found = "sphere:s{center{1 2 3} radius=4}";
    check("sphere s { center { 1 2 3 radius 4 }", found, &[UNCLOSED]);
    check("sphere s { center { 1 two 3 } }", "sphere:s{center{1 two=3}}", &[]);
}

#[test]
fn blocks_end_where_something_of_an_outer_one_begins() {
    let spheres = "sphere:a{center{1}!}! sphere:b{}";
    check("sphere a { center { 1 sphere b { }", spheres, &[UNCLOSED]);
    let camera = "camera:c{film:f{width=1}! fps=1}";
    check("camera c { film f { width 1 fps 1 }", camera, &[UNCLOSED]);
    check("camera c { film f { width 1 fps 1 } }", camera, &["`fps` can't stand in `film`"]);
    check(
        "sphere a { sphere b { } radius 1 } sphere c { }",
        "sphere:b{} sphere:a{radius=1} sphere:c{}",
        &["`sphere` can't stand in `sphere`"],
    );
}

#[test]
fn a_brace_too_many() {
    let sphere = "sphere:a{center{1} radius=1}";
    let early = "this `}` ends `sphere a` too early";
    check("sphere a { center { 1 } } radius 1 }", sphere, &[early]);
    check("sphere a { center { { 1 } radius 1 }", sphere, &["unexpected `{`"]);
    check("sphere a { center { { 1 } } radius 1 }", sphere, &["unexpected `{`"]);
    check("sphere a { { center { 1 } radius 1 }", sphere, &["unexpected `{`"]);
    check("sphere a { } }", "sphere:a{}!", &["this `}` closes nothing"]);
    check("{ { 1 } } sphere a { }", "sphere:a{}", &["expected a name in front of `{`"]);
}

#[test]
fn a_brace_too_few() {
    check("sphere a radius 1 }", "sphere:a{radius=1}", &["expected `{` after `sphere a`"]);
    check(
        "camera c { film f width 1 } fps 1 }",
        "camera:c{film:f{width=1} fps=1}",
        &["expected `{` after `film f`"],
    );
    check(
        "sphere a { key time 1 } radius 1 }",
        "sphere:a{key{time=1} radius=1}",
        &["expected `{` after `key`"],
    );
    check("sphere a { center 1 2 3 } radius 1 }", "sphere:a{center=1 2 3 radius=1}", &[]);
    check("sphere a { radius 1 center 1 2 3 }", "sphere:a{radius=1 center=1 2 3}", &[]);
    check("sphere a { center {", "sphere:a{center{}!}!", &[UNCLOSED]);
    check("/* sphere a { } ", "", &["this comment is never closed"]);
}

#[test]
fn a_brace_for_another() {
    let sphere = "sphere:a{center{1} radius=1}";
    let (open, close) = ("expected `{`, found `}`", "expected `}`, found `{`");
    check("sphere a } center { 1 } radius 1 }", sphere, &[open]);
    check("sphere a { center } 1 } radius 1 }", sphere, &[open]);
    check("sphere a { center { 1 { radius 1 }", sphere, &[close]);
    check("sphere a { center { 1 } radius 1 {", sphere, &[close]);
    check("sphere a { radius 1 { sphere b { }", "sphere:a{radius=1} sphere:b{}", &[close]);
    check("sphere a { center { 1 { }", "sphere:a{center{1}}", &[close]);
}

#[test]
fn brackets_for_braces() {
    let sphere = "sphere:a{center{1} radius=1}";
    let (round, square) = ("expected `{`, found `(`", "expected `{`, found `[`");
    check("sphere a { center (1) radius 1 }", sphere, &[round]);
    check("sphere a { center( 1 } radius 1 }", sphere, &[round]);
    check("sphere a [center [ 1 ]radius 1]", sphere, &[square, square]);
    check("sphere a { center <1> radius 1 }", sphere, &["expected `{`, found `<`"]);
    check("sphere a { center { 1) radius 1 )", sphere, &["expected `}`, found `)`"; 2]);
    check("sphere a { center { 1 } ) radius 1 }", sphere, &["unexpected `)`"]);
    check("sphere a { center { 1 } radius 1] ", sphere, &["expected `}`, found `]`"]);
}

#[test]
fn other_languages() {
    let sphere = "sphere:a{center{1} radius=1}";
    let comment = "a comment begins with `#`, not with `//`";
    let text = "// a } b\nsphere a { center { 1 // {\n} radius 1 //\n}";
    check(text, sphere, &[comment; 3]);
    check(
        "sphere a { center { 1 } ; radius 1 ; }; sphere b { center { 1 , 2 , 3 } }",
        "sphere:a{center{1} radius=1} sphere:b{center{1 2 3}}",
        &["unexpected `;`", "unexpected `;`", "unexpected `,`"],
    );
    let sign = "`radius` is followed by its value, without `=`";
    check("sphere a { radius = 1 }", "sphere:a{radius=1}", &[sign]);
    let sign = "`center` is followed by its value, without `:`";
    check("sphere a { center : { 1 } }", "sphere:a{center{1}}", &[sign]);
    let sign = "`a` is followed by `{`, without `=`";
    check("sphere a = { radius 1 }", "sphere:a{radius=1}", &[sign]);
    check("sphere a { material = radius 1 }", "sphere:a{material== radius=1}", &[]);
    check("sphere a\nsphere b { }", "sphere:a{}! sphere:b{}", &["expected `{` after `sphere a`"]);
    check("camera c { film 1 }", "camera:c{film:1{}!}", &["expected `{` after `film 1`"]);
}

#[test]
fn names_in_quotes_hold_anything_but_quotes() {
    check("sphere \"a b\" { material \"radius {\" }", "sphere:a b{material=radius {}", &[]);
    check("sphere \"(\"{material \"[a)\" }", "sphere:({material=[a)}", &[]);
    check(
        "camera c [ film \"x]\" [ width 1 ] ]",
        "camera:c{film:x]{width=1}}",
        &["expected `{`, found `[`"; 2],
    );
    check("sphere a { radius \"1\" }", "sphere:a{radius=\"1\"}", &[]);
}

#[test]
fn quotes_that_are_wrong() {
    let unclosed = "this `\"` is never closed";
    let empty = "a name can't be empty";
    check("sphere \"a { radius 1 }", "sphere:\"a{radius=1}", &[unclosed]);
    check("sphere a { material \"b c\nradius 1 }", "sphere:a{material=! radius=1}", &[unclosed]);
    check("sphere a { material \"b }", "sphere:a{material=!}", &[unclosed]);
    check("sphere a { material \" }", "sphere:a{material=!}", &[unclosed]);
    check("sphere a { material \"\" }", "sphere:a{material=!}", &[empty]);
    check("sphere \"a b { radius 1 }", "sphere:\"a{radius=1}", &[unclosed]);
    check("sphere \"a\"b\" { }", "sphere:a\"b{}", &["a name in quotes holds no quotes"]);
    check("sphere \"\" { radius 1 }", "sphere:\"\"{radius=1}", &[empty]);
}

#[test]
fn names_of_several_words_need_quotes() {
    let (name, value) = (
        "a name that holds white space stands in quotes",
        "a name or path that holds white space stands in quotes",
    );
    check("sphere a b c { radius 1 }", "sphere:a b c{radius=1}", &[name]);
    let text = "sphere a { material b  c.png radius 1 }";
    check(text, "sphere:a{material=b  c.png radius=1}", &[value]);
    let text = "sphere a { material b c radius 1 } sphere \"b c\" { }";
    check(text, "sphere:a{material=b c radius=1} sphere:b c{}", &[value]);
    let text = "sphere a { material b c radius 1 }";
    check(text, "sphere:a{material=b c radius=1}", &[]);
    let text = "sphere a { material b.png c.png }";
    check(text, "sphere:a{material=b.png c.png}", &[]);
    check("sphere a { material b\nc.png }", "sphere:a{material=b c.png}", &[]);
}

#[test]
fn a_colour_of_the_web_is_no_comment() {
    let color = "`#` begins a comment, so this is no colour";
    check("sphere a { center #cc1111 }", "sphere:a{center=!}", &[color]);
    check("sphere a { center { #fff } radius 1 }", "sphere:a{center{}! radius=1}", &[color]);
    check("sphere a { center #12 }\n{ 1 } }", "sphere:a{center{1}}", &[]);
    check("sphere a { center #fff\n{ #abc\n1 } }", "sphere:a{center{1}}", &[]);
}

#[test]
fn brackets_in_names_are_names() {
    check("sphere (a) { material [1] }", "sphere:(a){material=[1]}", &[]);
    check("sphere ( { material ) }", "sphere:({material=)}", &[]);
    check("sphere <b { radius 1 material a) }", "sphere:<b{radius=1 material=a)}", &[]);
}

#[test]
fn numbers_that_are_none_keep_their_place() {
    check(
        "center { 1 0,5 0,7 nan }",
        "center{1 ? ? ?}",
        &["`0,5` is not a number: the decimal sign is a point", "`nan` is not a finite number"],
    );
}

/// Work for each element in proportion to the length of its line would make this test run for minutes.
#[test]
fn a_long_scene_may_stand_in_one_line() {
    let (text, tree) = ("sphere s { radius 1 } ", "sphere:s{radius=1}");
    let count = 100_000;
    check(&text.repeat(count), &vec![tree; count].join(" "), &[]);
}
