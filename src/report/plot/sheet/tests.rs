//! Sheets: every name has its place, and nothing lies on anything else.

use super::{Curve, Panel, Sheet};

fn curve(name: &str, points: &[(f64, f64)]) -> Curve {
    let points = points.iter().map(|(x, y)| (*x, *y, false)).collect();
    Curve { name: name.into(), strong: false, points }
}

fn sheet(curves: Vec<Curve>) -> Sheet {
    let panel =
        Panel { title: "A <b>".into(), about: "of & such".into(), curves, notes: vec!["not shown".into()] };
    let other = Panel { title: "B".into(), ..panel.clone() };
    Sheet {
        title: "All".into(),
        about: vec!["how to".into()],
        x: "ns".into(),
        y: "error".into(),
        columns: 2,
        panels: vec![panel, other],
    }
}

/// Texts with their boxes: left, top, right, bottom.
fn boxes(svg: &str) -> Vec<(String, [f64; 4])> {
    let document = roxmltree::Document::parse(svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
    let number = |n: &roxmltree::Node, key: &str| n.attribute(key).and_then(|v| v.parse::<f64>().ok());
    let boxed = |n: roxmltree::Node| {
        let (x, y, size) = (number(&n, "x")?, number(&n, "y")?, number(&n, "font-size")?);
        let text = n.children().filter(|c| c.is_text()).filter_map(|c| c.text()).collect::<String>();
        let wide = 0.95 * size * super::width(&text);
        let left = match n.attribute("text-anchor") {
            Some("middle") => x - wide / 2.0,
            Some("end") => x - wide,
            _ => x,
        };
        Some((text, [left, y - 0.7 * size, left + wide, y + 0.2 * size]))
    };
    document.descendants().filter(|n| n.has_tag_name("text")).filter_map(boxed).collect()
}

#[test]
fn every_curve_has_its_name_and_no_text_lies_on_another() {
    // Curves that nearly coincide, as methods of like cost do.
    let curves = (0..10)
        .map(|n| {
            let x = 20.0 + f64::from(n);
            curve(&format!("method {n}"), &[(x, 1e-3), (x * 1.01, 1e-6), (x, 3e-9), (x, 1e-15)])
        })
        .collect();
    let boxes = boxes(&sheet(curves).svg());
    for n in 0..10 {
        let name = format!("method {n}");
        assert_eq!(boxes.iter().filter(|(text, _)| *text == name).count(), 2, "{name}");
    }
    for (i, (a, [l, t, r, b])) in boxes.iter().enumerate() {
        for (other, [l2, t2, r2, b2]) in &boxes[i + 1..] {
            assert!(r < l2 || r2 < l || b < t2 || b2 < t, "`{a}` lies on `{other}`");
        }
    }
}

#[test]
fn all_that_is_said_is_text() {
    let texts = boxes(&sheet(vec![curve("one", &[(1.0, 1.0)])]).svg());
    for text in ["All", "how to", "A <b>", "B", "of & such", "not shown", "one", "ns"] {
        assert!(texts.iter().any(|(known, _)| known == text), "{text}");
    }
}

#[test]
fn nothing_and_nonsense_are_still_a_picture() {
    let bad = [(f64::NAN, 1.0), (1.0, f64::INFINITY), (0.0, 1.0), (1.0, -1.0)];
    for curves in
        [vec![], vec![curve("", &[])], vec![curve("bad", &bad)], vec![curve("x", &[(1e300, 5e-324)])]]
    {
        let svg = sheet(curves).svg();
        boxes(&svg);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
    boxes(&Sheet::default().svg());
}
