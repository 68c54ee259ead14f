//! xacro: what templates stand for, what is wrong with them, and that they end.

use crate::common::{load, loaded};
use robot_model::{Problems, expand_xacro};
use std::collections::BTreeMap;

/// What a text inside `<robot>` becomes, without the declaration and the blanks between elements.
fn expanded_with(
    inner: &str,
    files: &[(&str, &str)],
    arguments: &[(&str, &str)],
) -> Result<String, Problems> {
    let text = format!("<robot xmlns:xacro='http://www.ros.org/wiki/xacro'>{inner}</robot>");
    let arguments = arguments
        .iter()
        .map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
    let arguments: BTreeMap<String, String> = arguments.collect();
    let mut read = |address: &str| {
        let found = files.iter().find(|(name, _)| *name == address);
        let text = found.map(|(_, text)| text.as_bytes().to_vec());
        text.ok_or_else(|| "no such file".to_owned())
    };
    let text = expand_xacro("pkg/urdf/r.xacro", &text, &arguments, &mut read)?;
    let lines: String = text.lines().skip(1).map(str::trim).collect();
    let inner = lines
        .strip_prefix("<robot>")
        .and_then(|it| it.strip_suffix("</robot>"));
    Ok(inner.map_or_else(|| lines.replace("<robot/>", ""), str::to_owned))
}

fn expanded(inner: &str) -> String {
    expanded_with(inner, &[], &[]).unwrap_or_else(|problems| panic!("{problems}\n{inner}"))
}

fn wrong(inner: &str) -> String {
    match expanded_with(inner, &[], &[]) {
        Ok(text) => panic!("accepted: {inner}\n{text}"),
        Err(problems) => problems.to_string(),
    }
}

#[test]
fn expressions_give_what_python_gives() {
    // The right column is what the Python program xacro 2.1.1 prints.
    for (expression, value) in [
        ("1 + 2 * 3", "7"),
        ("7 / 2", "3.5"),
        ("-7 // 2", "-4"),
        ("7 // -2", "-4"),
        ("-7 % 3", "2"),
        ("7.5 % -2", "-0.5"),
        ("2 ** 3 ** 2", "512"),
        ("-2 ** 2", "-4"),
        ("2 ** -1", "0.5"),
        ("0.1 + 0.2", "0.30000000000000004"),
        ("1e-7 * 1", "1e-07"),
        ("pi / 2", "1.5707963267948966"),
        ("sin(radians(30))", "0.49999999999999994"),
        ("math.sqrt(2)", "1.4142135623730951"),
        ("round(2.5)", "2"),
        ("round(2.675, 2)", "2.67"),
        ("'a' + 'b' * 2", "abb"),
        ("'%s_%02d' % ('w', 3)", "w_03"),
        ("1 &lt; 2 and not 3 == 4", "True"),
        ("1 &lt; 2 &lt; 2", "False"),
        ("'x' if 0 else 'y'", "y"),
        ("0 or 'default'", "default"),
        ("[1, 2.0, 'c'][1]", "2.0"),
        ("[i * i for i in range(4) if i % 2]", "[1, 9]"),
        ("len('abc') + max(1, 5, 2)", "8"),
        ("'a,b'.split(',')[-1].upper()", "B"),
        ("'left' in ['left', 'right']", "True"),
        ("'abcdef'[1:4]", "bcd"),
        ("[3, 1, 2][::-1]", "[2, 1, 3]"),
        ("dict(a=1)['a']", "1"),
        ("int('12') + float('0.5')", "12.5"),
        ("str(1.0) + str(True)", "1.0True"),
        ("None", "None"),
        ("(1,)", "(1,)"),
        ("python.sum([0.1] * 3)", "0.30000000000000004"),
        ("'%.3f' % 2", "2.000"),
        ("~5 | 3", "-5"),
        ("1 &lt;&lt; 4", "16"),
    ] {
        let text = format!("<a v=\"${{{expression}}}\"/>");
        assert_eq!(
            expanded(&text),
            format!("<a v=\"{value}\"/>"),
            "{expression}"
        );
    }
}

#[test]
fn properties_are_evaluated_when_they_are_asked_for_and_keep_their_type() {
    let text = "<xacro:property name='b' value='${2 * a}'/><xacro:property name='a' value='3'/><x v='${b}'/>";
    assert_eq!(expanded(text), "<x v=\"6\"/>");
    // What reads as a number is one, in quotes too, since it is read again when it is asked for.
    let text = "<xacro:property name='n' value='010'/><xacro:property name='t' value=\"'010'\"/><x n='${n}' t='${t}'/>";
    assert_eq!(expanded(text), "<x n=\"10\" t=\"10\"/>");
    let text = "<xacro:property name='a' value='1'/><xacro:property name='b' value='${a}' lazy_eval='false'/>\
        <xacro:property name='a' value='2'/><x v='${a}${b}'/>";
    assert_eq!(expanded(text), "<x v=\"21\"/>");
    let text = "<xacro:property name='a' value='1'/><xacro:property name='a' default='2'/>\
        <xacro:property name='c' default='3'/><x v='${a}${c}'/><xacro:property name='a' remove='true'/>\
        <xacro:property name='a' default='4'/><x v='${a}'/>";
    assert_eq!(expanded(text), "<x v=\"13\"/><x v=\"4\"/>");
    assert_eq!(
        expanded("<x v='$${a}' w='$5'/>"),
        "<x v=\"${a}\" w=\"$5\"/>"
    );
    assert_eq!(expanded("<t>${1 + 1} and ${'x'}</t>"), "<t>2 and x</t>");
}

#[test]
fn macros_have_parameters_defaults_blocks_and_what_the_caller_has() {
    let text = "<xacro:macro name='m' params='a b:=2 c:=^|9 d:=^ *one **many'>\
        <x a='${a}' b='${b}' c='${c}' d='${d}'><xacro:insert_block name='one'/><xacro:insert_block name='many'/></x>\
        </xacro:macro>\
        <xacro:property name='d' value='4'/>\
        <xacro:m a='${d - 3}'><o v='${d}'/><all><p/><q/></all></xacro:m>";
    assert_eq!(
        expanded(text),
        "<x a=\"1\" b=\"2\" c=\"9\" d=\"4\"><o v=\"4\"/><p/><q/></x>"
    );
    // What a macro defines is its own, unless it says otherwise.
    let text = "<xacro:macro name='m' params=''><xacro:property name='own' value='1'/>\
        <xacro:property name='up' value='${own + 1}' scope='parent'/>\
        <xacro:property name='all' value='${own + 2}' scope='global'/></xacro:macro>\
        <xacro:macro name='n' params=''><xacro:m/><x v='${up}${all}'/></xacro:macro>\
        <xacro:n/><y v='${all}'/>";
    assert_eq!(expanded(text), "<x v=\"23\"/><y v=\"3\"/>");
    // A block that is a property, a macro by name, one inside another.
    let text = "<xacro:property name='inertia'><i v='1'/><j/></xacro:property>\
        <xacro:macro name='wheel' params='side'><w s='${side}'><xacro:insert_block name='inertia'/></w></xacro:macro>\
        <xacro:call macro='${\"whe\" + \"el\"}' side='left'/>";
    assert_eq!(expanded(text), "<w s=\"left\"><i v=\"1\"/><j/></w>");
}

#[test]
fn conditions_elements_and_attributes_are_made() {
    let text = "<xacro:if value='${1 &gt; 2}'><a/></xacro:if><xacro:unless value='false'><b/></xacro:unless>\
        <xacro:if value='1'><c/></xacro:if><xacro:if value='${not 0.0}'><d/></xacro:if>";
    assert_eq!(expanded(text), "<b/><c/><d/>");
    let text = "<xacro:element xacro:name='${\"li\" + \"nk\"}' name='a'/>\
        <joint><xacro:attribute name='type' value='${\"fix\" + \"ed\"}'/></joint>";
    assert_eq!(expanded(text), "<link name=\"a\"/><joint type=\"fixed\"/>");
}

#[test]
fn files_are_included_with_what_they_define_and_packages_are_found_by_their_address() {
    let files = [
        (
            "pkg/urdf/parts/wheel.xacro",
            "<robot xmlns:xacro='x'><xacro:property name='r' value='0.5'/>\
            <xacro:include filename='hub.xacro'/><xacro:macro name='wheel' params='n'><w n='${n}' r='${r}' h='${hub}'/></xacro:macro></robot>",
        ),
        (
            "pkg/urdf/parts/hub.xacro",
            "<robot xmlns:xacro='x'><xacro:property name='hub' value='7'/></robot>",
        ),
        (
            "package://arm/config/limits.yaml",
            "joints:\n  elbow: {max: !degrees 180, names: [a, b]}\n",
        ),
    ];
    let with = |text: &str| expanded_with(text, &files, &[]);
    let text = "<xacro:include filename='parts/wheel.xacro'/><xacro:wheel n='1'/>";
    assert_eq!(with(text).as_deref(), Ok("<w n=\"1\" r=\"0.5\" h=\"7\"/>"));
    let text = "<xacro:include filename='parts/wheel.xacro' ns='p'/><xacro:p.wheel n='${p.r}'/>";
    assert_eq!(
        with(text).as_deref(),
        Ok("<w n=\"0.5\" r=\"0.5\" h=\"7\"/>")
    );
    let text = "<xacro:property name='c' value=\"${xacro.load_yaml('$(find arm)/config/limits.yaml')}\"/>\
        <x v=\"${c['joints']['elbow']['max']}\" w='${c.joints.elbow.names[1]}'/>";
    assert_eq!(
        with(text).as_deref(),
        Ok("<x v=\"3.141592653589793\" w=\"b\"/>")
    );
    assert_eq!(
        with("<xacro:include filename='none.xacro' optional='true'/>").as_deref(),
        Ok("")
    );
    assert_eq!(
        with("<m f='file://$(find arm)/a.stl'/>").as_deref(),
        Ok("<m f=\"package://arm/a.stl\"/>")
    );
    let missing = with("<xacro:include filename='none.xacro'/>")
        .expect_err("none")
        .to_string();
    assert!(
        missing.starts_with("pkg/urdf/r.xacro:1:")
            && missing.contains("pkg/urdf/none.xacro cannot be had"),
        "{missing}"
    );
}

#[test]
fn arguments_have_the_value_that_they_are_first_given() {
    let text = "<xacro:arg name='a' default='1'/><xacro:arg name='a' default='2'/><x v='$(arg a)' w='$(eval a + 1)'/>";
    assert_eq!(expanded(text), "<x v=\"1\" w=\"2\"/>");
    assert_eq!(
        expanded_with(text, &[], &[("a", "5")]).as_deref(),
        Ok("<x v=\"5\" w=\"6\"/>")
    );
    assert_eq!(
        expanded("<x v='$(optenv HOME none at all)'/>"),
        "<x v=\"none at all\"/>"
    );
}

#[test]
fn mistakes_have_a_place_a_reason_and_a_remedy() {
    for (text, expected) in [
        (
            "\n<a v='${1 +}'/>",
            "r.xacro:2:4: it ends where a value is expected in `${1 +}`",
        ),
        ("<a v='${b}'/>", "there is no property `b`"),
        ("<a v='${1 / 0}'/>", "divided by 0"),
        ("<a v='$(arg b)'/>", "no argument `b`: declare it"),
        ("<a v='$(env HOME)'/>", "no environment is read"),
        ("<a v='${b'/>", "not closed"),
        ("<xacro:b/>", "there is no macro `b`"),
        ("<xacro:if value='maybe'/>", "neither true nor false"),
        ("<xacro:property value='1'/>", "has no `name`"),
        (
            "<xacro:property name='1a' value='1'/>",
            "cannot be the name",
        ),
        ("<xacro:insert_block name='b'/>", "no block `b`"),
        (
            "<xacro:macro name='m' params='a'/><xacro:m/>",
            "parameter `a` has no value",
        ),
        (
            "<xacro:macro name='m' params='a'/><xacro:m a='1' b='2'/>",
            "no parameter `b`",
        ),
        (
            "<xacro:macro name='m' params='*a'/><xacro:m/>",
            "block `a` is missing",
        ),
        (
            "<xacro:macro name='m'/><xacro:m><a/></xacro:m>",
            "takes no more blocks",
        ),
        (
            "<xacro:property name='a' value='${b}'/><xacro:property name='b' value='${a}'/><x v='${a}'/>",
            "defined by itself",
        ),
        (
            "<xacro:macro name='m'><x v='${nothing}'/></xacro:macro>\n<xacro:m/>",
            "in macro `m`, called at pkg/urdf/r.xacro:2:1",
        ),
    ] {
        let said = wrong(text);
        assert!(said.contains(expected), "{text}\n{said}\nlacks: {expected}");
        assert!(
            said.starts_with("pkg/urdf/r.xacro:") && said.contains("; "),
            "{said}"
        );
    }
}

#[test]
fn templates_without_an_end_are_refused() {
    let doubling: String = (1..60)
        .map(|n| {
            format!(
                "<xacro:macro name='m{n}'><xacro:m{0}/><xacro:m{0}/></xacro:macro>",
                n - 1
            )
        })
        .collect();
    let lists: String = (1..60)
        .map(|n| {
            format!(
                "<xacro:property name='p{n}' value='${{[p{0}, p{0}]}}'/>",
                n - 1
            )
        })
        .collect();
    let chain: String = (1..2_000)
        .map(|n| format!("<xacro:property name='p{n}' value='${{p{}}}'/>", n - 1))
        .collect();
    let deep = format!("{}{}", "<a>".repeat(300), "</a>".repeat(300));
    for (text, expected) in [
        (
            "<xacro:macro name='m'><xacro:m/></xacro:macro><xacro:m/>".to_owned(),
            "nested more than",
        ),
        (
            format!("<xacro:macro name='m0'><x/></xacro:macro>{doubling}<xacro:m50/>"),
            "elements",
        ),
        (
            format!("<xacro:property name='p0' value='${{[1]}}'/>{lists}<x v='${{p50}}'/>"),
            "values",
        ),
        (
            format!("<xacro:property name='p0' value='1x'/>{chain}<x v='${{p1999}}'/>"),
            "defined by one another",
        ),
        ("<x v=\"${'a' * 10000000}\"/>".to_owned(), "longer than"),
        ("<x v='${[0] * 10 ** 9}'/>".to_owned(), "longer than"),
        ("<x v='${list(range(10 ** 12))}'/>".to_owned(), "more than"),
        ("<x v='${10 ** 100}'/>".to_owned(), "too large"),
        (
            "<x v='${[[j for j in range(100000)] for i in range(100000)]}'/>".to_owned(),
            "work",
        ),
        (deep, "nested more than"),
    ] {
        let said = wrong(&text);
        assert!(
            said.contains(expected),
            "{}\n{said}\nlacks: {expected}",
            &text[..80]
        );
    }
    let itself = [(
        "pkg/urdf/r.xacro",
        "<robot xmlns:xacro='x'><xacro:include filename='r.xacro'/></robot>",
    )];
    let said = expanded_with("<xacro:include filename='r.xacro'/>", &itself, &[])
        .expect_err("it has no end");
    assert!(said.to_string().contains("nested more than"), "{said}");
}

#[test]
fn a_robot_in_xacro_is_loaded_as_the_one_that_it_stands_for() {
    let template = "<robot name='cart' xmlns:xacro='http://www.ros.org/wiki/xacro'>\
        <xacro:property name='mass' value='2'/>\
        <xacro:macro name='body' params='name'><link name='${name}'><inertial><mass value='${mass / 2}'/>\
        <inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial></link></xacro:macro>\
        <xacro:body name='base'/><xacro:body name='wheel'/>\
        <joint name='axle' type='continuous'><parent link='base'/><child link='wheel'/><axis xyz='0 1 0'/></joint></robot>";
    let found = loaded("cart.urdf.xacro", template);
    let names: Vec<&str> = found
        .model
        .links
        .iter()
        .map(|link| link.name.as_str())
        .collect();
    assert_eq!(names, ["base", "wheel"]);
    let masses = found.model.links.iter().filter_map(|link| link.inertial);
    assert_eq!(masses.map(|it| it.mass_kg).sum::<f64>(), 2.0);
    let problems = load("cart.xacro", &template.replace("/ 2", "/ 0")).expect_err("no mass");
    assert_eq!(problems.0.len(), 1, "{problems}");
}

/// The template that is held against the Python program, and the files that it includes.
const ARM: &str = include_str!("../../../../tests/robots/templates/urdf/arm.urdf.xacro");
const PARTS: &str = include_str!("../../../../tests/robots/templates/urdf/parts.xacro");
const LIMITS: &str = include_str!("../../../../tests/robots/templates/config/limits.yaml");

fn arm(arm: &str, parts: &str, limits: &str) -> Result<String, Problems> {
    let mut read = |address: &str| match address.rsplit('/').next() {
        Some("parts.xacro") => Ok(parts.as_bytes().to_vec()),
        Some("limits.yaml") => Ok(limits.as_bytes().to_vec()),
        _ => Err("no such file".to_owned()),
    };
    expand_xacro("arm.urdf.xacro", arm, &BTreeMap::new(), &mut read)
}

#[test]
fn a_whole_robot_becomes_links_and_joints() {
    let text = arm(ARM, PARTS, LIMITS).unwrap_or_else(|problems| panic!("{problems}"));
    assert_eq!(text.matches("<link ").count(), 6, "{text}");
    assert_eq!(text.matches("type=\"revolute\"").count(), 2, "{text}");
    assert!(!text.contains("xacro"), "{text}");
    assert!(
        text.contains("lower=\"-1.5707963267948966\" upper=\"1.5707963267948966\" effort=\"10\""),
        "{text}"
    );
}

proptest::proptest! {
    #![proptest_config(proptest::test_runner::Config::with_cases(300))]
    #[test]
    fn damaged_templates_are_refused_or_expanded_and_never_hang(
        which in 0..3_usize, at in 0.0..1.0_f64, length in 0..12_usize,
        put in proptest::sample::select(vec!["", "${", "}", "$(", "*", "'", "[", "- ", ": ", "<", "/>", "^|", "**", "&a ", "if "]),
    ) {
        let mut texts = [ARM.to_owned(), PARTS.to_owned(), LIMITS.to_owned()];
        let text = &mut texts[which];
        let from = (at * text.len() as f64) as usize;
        let to = (from + length).min(text.len());
        text.replace_range(from..to, put);
        if let Err(problems) = arm(&texts[0], &texts[1], &texts[2]) {
            proptest::prop_assert!(problems.0.iter().all(|it| it.place.line > 0 && !it.remedy.is_empty()));
        }
    }
}
