use super::*;

const TEXT: &str = "\
# A ball on a floor
Scaling { 2 }
phong_info red { diffuse { .8 .1 .1 } } /* glossy */ material_phong red { phong_info red }
sphere ball {
    center { 0 0 1 } # above the floor
    radius 1   /* small */
    material red
    addKframe { time 0 key { pivot { 0 0 0 } } }
    addKframe { time 1 key { pivot { 1  0\t0 } } } # there
}
mesh \"red box\" { filename \"a b.slo\" material red }
sphere empty {}
";

/// Checks what a change makes of the text: the lines that differ.
fn check(edits: impl FnOnce(&Outline<'_>) -> Vec<Edit>, expected: &[(&str, &str)]) {
    check_in(TEXT, edits, expected);
}

fn check_in(text: &str, edits: impl FnOnce(&Outline<'_>) -> Vec<Edit>, expected: &[(&str, &str)]) {
    let changed = applied(text, edits(&Outline::new(text))).expect("the changes fit");
    let mut wanted = text.to_owned();
    for (old, new) in expected {
        assert_eq!(wanted.matches(old).count(), 1, "{old}");
        wanted = wanted.replace(old, new);
    }
    assert_eq!(changed, wanted);
}

fn ball<'t, 'a>(outline: &'t Outline<'a>) -> Part<'t, 'a> {
    outline.element("sphere", "ball").expect("it is there")
}

#[test]
fn values_are_replaced_and_nothing_else() {
    check(|text| ball(text).set("radius", "2.5"), &[("radius 1 ", "radius 2.5 ")]);
    check(|text| ball(text).set("material", "blue"), &[("    material red", "    material blue")]);
    let box_of = |text: &Outline<'_>| {
        text.element("mesh", "red box").expect("it is there").set("filename", "c.slo")
    };
    check(box_of, &[("\"a b.slo\"", "c.slo")]);
}

#[test]
fn only_numbers_that_differ_are_replaced() {
    check(|text| ball(text).set("center", "0 -.5 1.0"), &[("{ 0 0 1 }", "{ 0 -.5 1 }")]);
    check(|text| ball(text).set("center", "0 0 1"), &[]);
    let last = |text: &Outline<'_>| {
        let frame = ball(text).parts("addKframe").nth(1).expect("it is there");
        frame.part("key").expect("it is there").set("pivot", "1 2 0")
    };
    check(last, &[("{ 1  0\t0 }", "{ 1  2\t0 }")]);
}

#[test]
fn what_is_missing_is_added_as_the_rest_is_written() {
    let hidden = |text: &Outline<'_>| ball(text).set("hidden", "1");
    check(hidden, &[("# there\n", "# there\n    hidden 1\n")]);
    let red = |text: &Outline<'_>| {
        let red = text.element("phong_info", "red").expect("it is there");
        red.set_vector("ambient", "0 0 .1")
    };
    check(red, &[(".1 .1 } }", ".1 .1 } ambient { 0 0 .1 } }")]);
    let empty = |text: &Outline<'_>| {
        text.element("sphere", "empty").expect("it is there").set("radius", "1")
    };
    check(empty, &[("{}", "{ radius 1 }")]);
    let frame = |text: &Outline<'_>| {
        let frames: Vec<_> = ball(text).parts("addKframe").collect();
        vec![frames[0].follow("addKframe { time .5 key { pivot { 0 1 0 } } }")]
    };
    let first = "addKframe { time 0 key { pivot { 0 0 0 } } }\n";
    let both = format!("{first}    addKframe {{ time .5 key {{ pivot {{ 0 1 0 }} }} }}\n");
    check(frame, &[(first, &both)]);
}

#[test]
fn elements_go_with_their_lines() {
    let whole = TEXT.split_inclusive('\n').skip(3).take(7).collect::<String>();
    check(|text| vec![ball(text).remove()], &[(&whole, "")]);
    let material = |text: &Outline<'_>| {
        vec![text.element("material_phong", "red").expect("it is there").remove()]
    };
    check(material, &[(" material_phong red { phong_info red }", "")]);
    let frame =
        |text: &Outline<'_>| vec![ball(text).parts("addKframe").nth(1).expect("it").remove()];
    check(frame, &[("    addKframe { time 1 key { pivot { 1  0\t0 } } } # there", " # there")]);
}

#[test]
fn copies_follow() {
    let copy = |text: &Outline<'_>| vec![ball(text).follow("copy ball2 { of ball }")];
    check(copy, &[("# there\n}\n", "# there\n}\ncopy ball2 { of ball }\n")]);
    let red = |text: &Outline<'_>| {
        vec![text.element("phong_info", "red").expect("it is there").follow("x y {}")]
    };
    check(red, &[(" /* glossy */", "\nx y {} /* glossy */")]);
}

#[test]
fn line_endings_stay() {
    let text = "sphere ball {\r\n\tradius 1 # small\r\n}\r\n";
    check_in(
        text,
        |text| ball(text).set("hidden", "1"),
        &[("small\r\n", "small\r\n\thidden 1\r\n")],
    );
    check_in(text, |text| vec![ball(text).remove()], &[(text, "")]);
    check_in(text, |text| vec![ball(text).follow("a b {}")], &[("}\r\n", "}\r\na b {}\r\n")]);
}

#[test]
fn values_can_be_read() {
    let outline = Outline::new(TEXT);
    assert_eq!(outline.first("Scaling").expect("it is there").own_numbers(), Some(vec![2.0]));
    let ball = ball(&outline);
    assert_eq!((ball.value("radius"), ball.value("center")), (Some("1"), Some("0 0 1")));
    assert_eq!((ball.numbers("center"), ball.value("hidden")), (Some(vec![0.0, 0.0, 1.0]), None));
    assert_eq!((ball.line(), ball.keyword(), ball.name()), (4, "sphere", Some("ball")));
    let names: Vec<_> = ball.names().collect();
    assert_eq!(names, ["center", "radius", "material", "addKframe", "addKframe"]);
}

#[test]
fn changes_that_overlap_are_refused() {
    let edit = |range| Edit { range, text: "x".into() };
    assert_eq!(applied("abcdef", vec![edit(3..4), edit(0..2)]).as_deref(), Some("xcxef"));
    assert_eq!(applied("abcdef", vec![edit(0..3), edit(2..4)]), None);
    assert_eq!(applied("abc", vec![edit(2..9)]), None);
    assert_eq!(applied("aß", vec![edit(2..3)]), None);
}

#[test]
fn what_lacks_a_brace_is_no_element() {
    for text in [
        "light_point l {\n color { 1 1 1 }\n position { 0 0 0 }\nsphere s { radius 1 }",
        "light_point l {\n color { 1 1 1 \n position { 0 0 0 } }",
        "sphere s radius 1 }",
        "sphere s { radius 1 ",
    ] {
        for part in Outline::new(text).elements() {
            for edit in
                [vec![part.add("radius 2")], part.set("color", "1 2 3"), vec![part.remove()]]
            {
                assert!(applied(text, edit).is_some(), "{text}");
            }
        }
    }
    let text = "light_point l {\n color { 1 1 1 }\n position { 0 0 0 }\n";
    assert!(Outline::new(text).element("light_point", "l").is_none());
}

#[test]
fn attributes_can_be_taken_out() {
    let text =
        "mesh m { filename a.slo filename \"b c.slo\"\n  fit { 2 } # size\n  material red }\n";
    let mesh = |text: &Outline<'_>, name: &str, kept| {
        text.element("mesh", "m").expect("it is there").without(name, kept)
    };
    check_in(text, |text| mesh(text, "filename", 1), &[(" filename \"b c.slo\"", "")]);
    check_in(text, |text| mesh(text, "fit", 0), &[("fit { 2 } # size", "# size")]);
    check_in(text, |text| mesh(text, "axes", 0), &[]);
}

#[test]
fn comments_belong_to_what_they_stand_at() {
    let comments = |text: &str, keyword: &str| {
        let outline = Outline::new(text);
        let range = outline.first(keyword).expect("it is there").with_comments();
        text[range].to_owned()
    };
    let text = "# of the file\n\n# above\n/* too */\nsphere a { } # behind\n# of b\nbox b { } cone c { }\n";
    assert_eq!(comments(text, "sphere"), "# above\n/* too */\nsphere a { } # behind");
    assert_eq!(comments(text, "box"), "# of b\nbox b { }");
    assert_eq!(comments(text, "cone"), "cone c { }");
    assert_eq!(comments("a */\nsphere a {}/**/ box b {}", "sphere"), "sphere a {}");
}

#[test]
fn lines_are_added_at_the_end() {
    let after = |text: &str| applied(text, vec![append(text, "a\nb")]).expect("it fits");
    assert_eq!(after(""), "a\nb\n");
    assert_eq!(after("x"), "x\na\nb\n");
    assert_eq!(after("x\r\n"), "x\r\na\r\nb\r\n");
    assert_eq!(
        Outline::new("include a.txt\ninclude \"b c.txt\" sphere a {}").includes().count(),
        2
    );
}
