use super::date::is_date;
use super::{Calibration, Unit};

fn blank() -> Calibration {
    let (unit_word, unit) = Unit::at(0);
    Calibration {
        name: "c".into(),
        date: "2026-03-14".into(),
        method: "laser".into(),
        area: 1e-4,
        site: None,
        unit,
        unit_word,
        points: Vec::new(),
        file: Some("c.csv".into()),
        span: 0..0,
        table_span: 0..0,
    }
}

/// As in events files: a comma within quotes divides nothing.
#[test]
fn tables_may_quote_cells() {
    let mut calibration = blank();
    let text = "\u{feff}\"remark, if any\", frequency ,\"output\"\n\"loose, then \"\"tight\"\"\",50,\"1e-6\"\n# none\n,60, 2e-6\n";
    assert_eq!(calibration.take(text), Ok(()));
    assert_eq!(calibration.points, [[50.0, 1e-6], [60.0, 2e-6]]);
    for (text, span) in [("frequency,output\n50,\"1\n60,2\n", 17..22), ("\"frequency,output\n50,1\n", 0..17)]
    {
        let problems = calibration.take(text).unwrap_err();
        assert_eq!(problems.len(), 1, "{problems:?}");
        assert_eq!((problems[0].span.clone(), calibration.points.len()), (Some(span), 0), "{text}");
    }
}

#[test]
fn dates_are_days_that_there_were() {
    for good in ["2026-03-14", "2024-02-29", "2000-02-29", "1999-12-31"] {
        assert!(is_date(good), "{good}");
    }
    let bad = [
        "",
        "2026",
        "2026-3-14",
        "26-03-14",
        "2026-13-01",
        "2026-00-01",
        "2026-04-31",
        "2025-02-29",
        "1900-02-29",
        "2026-03-14T10:00:00",
        "+026-03-14",
    ];
    for bad in bad {
        assert!(!is_date(bad), "{bad}");
    }
}
