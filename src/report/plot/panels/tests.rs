use super::{Across, Form, Ink, Panel, Panels, Shape, span};

fn panels(log: bool, points: &[(f64, f64)]) -> Panels {
    let axis = |label: &str| Across { label: label.into(), range: [0.1, 10.0], log, rows: Vec::new() };
    let forms = [Form::Line(1.5), Form::Dashed(1.0, "4 2"), Form::Area(0.2), Form::Marks(1), Form::Ticks];
    let shape = |(n, form): (usize, Form)| Shape {
        name: format!("shape <{n}> of a long name"),
        ink: Ink::Kind { index: n },
        form,
        points: points.to_vec(),
    };
    Panels {
        title: "a & b".into(),
        about: vec!["of which".into()],
        panels: vec![Panel {
            frame: [90.0, 0.0, 500.0, 200.0],
            x: axis("time (s)"),
            y: axis("angle (rad)"),
            shapes: forms.into_iter().enumerate().map(shape).collect(),
        }],
        notes: vec![("mind".into(), true)],
        width: 620.0,
    }
}

#[test]
fn whatever_the_points_it_is_a_picture() {
    let sets: [&[(f64, f64)]; 5] = [
        &[],
        &[(1.0, 1.0)],
        &[(0.0, -1.0), (f64::INFINITY, f64::NEG_INFINITY)],
        &[(1.0, 1.0), (f64::NAN, 2.0), (3.0, 3.0)],
        &[(f64::MAX, f64::MIN), (5e-324, 5e-324)],
    ];
    for points in sets {
        for log in [false, true] {
            let svg = panels(log, points).svg();
            roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e} in\n{svg}"));
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
    roxmltree::Document::parse(&Panels::default().svg()).unwrap();
}

#[test]
fn entries_of_the_key_do_not_overlap() {
    let panels = panels(false, &[(1.0, 1.0)]);
    let key = panels.key();
    assert_eq!(key.len(), 5);
    for pair in key.windows(2) {
        let apart = pair[1].1 > pair[0].1 || pair[1].0 >= pair[0].0 + 34.0;
        assert!(apart, "{} {}", pair[0].0, pair[1].0);
    }
    assert!(key.iter().all(|(x, _, shape)| x + 34.0 + 12.0 * super::width(&shape.name) <= 620.0));
}

#[test]
fn a_line_parts_where_a_point_is_none() {
    let lines = |points: &[(f64, f64)]| panels(false, points).svg().matches("fill=\"none\"").count();
    assert_eq!(
        lines(&[(1.0, 1.0), (2.0, 2.0), (f64::NAN, 0.0), (3.0, 1.0), (4.0, 2.0)]),
        lines(&[(1.0, 1.0), (2.0, 2.0)]) + 2
    );
}

#[test]
fn spans_are_ranges() {
    assert_eq!(span([f64::NAN], &[]), [0.0, 1.0]);
    for values in [vec![0.0], vec![3.0, 3.0], vec![-1.0, 2.0], vec![1e300, -1e300], vec![1e-300]] {
        let [from, to] = span(values.iter().copied(), &[]);
        assert!(from < to && values.iter().all(|v| (from..=to).contains(v)), "{values:?} {from} {to}");
    }
}
