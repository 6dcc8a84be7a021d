//! The picture of body coordinates: `docs/body.svg` is drawn from the layouts themselves (`UPDATE_DOCS=1 cargo test --test body` writes it).

use pacinian::space::layout::{Hand, Layout, belt, hand, sleeve, vest};
use std::fmt::Write as _;
use std::path::Path;

/// Which coordinates go to the right and up on paper, and the one toward whoever looks, where `toward` is 1, or away.
#[derive(Clone, Copy)]
struct View {
    right: usize,
    up: usize,
    deep: usize,
    toward: f64,
    /// Pixels a metre.
    scale: f64,
    /// Where the origin is on the page.
    origin: [f64; 2],
}

const NAMES: [&str; 3] = ["x, to the right", "y, up", "z, ahead"];

impl View {
    fn at(&self, right: f64, up: f64) -> [f64; 2] {
        [self.origin[0] + self.scale * right, self.origin[1] - self.scale * up]
    }

    /// A closed outline of points right and up of the origin, m, rounded off.
    fn outline(&self, page: &mut String, points: &[[f64; 2]]) {
        let on_page: Vec<[f64; 2]> = points.iter().map(|[x, y]| self.at(*x, *y)).collect();
        let half = |k: usize| {
            let ([a, b], [c, d]) = (on_page[k % on_page.len()], on_page[(k + 1) % on_page.len()]);
            [0.5 * (a + c), 0.5 * (b + d)]
        };
        let [x, y] = half(0);
        let mut path = format!("M{x:.1} {y:.1}");
        for k in 1..=on_page.len() {
            let ([a, b], [x, y]) = (on_page[k % on_page.len()], half(k));
            let _ = write!(path, "Q{a:.1} {b:.1} {x:.1} {y:.1}");
        }
        let _ = writeln!(page, "<path class=\"body\" d=\"{path}Z\"/>");
    }

    /// Limbs from one point to another, so many metres thick, that grow out of an outline.
    fn grown(&self, page: &mut String, points: &[[f64; 2]], limbs: &[([[f64; 2]; 2], f64)]) {
        let drawn = |page: &mut String, class: &str, wider: f64| {
            for ([from, to], thick) in limbs {
                let ([a, b], [c, d]) = (self.at(from[0], from[1]), self.at(to[0], to[1]));
                let _ = writeln!(
                    page,
                    "<line class=\"{class}\" x1=\"{a:.1}\" y1=\"{b:.1}\" x2=\"{c:.1}\" y2=\"{d:.1}\" stroke-width=\"{:.1}\"/>",
                    thick * self.scale + wider
                );
            }
        };
        drawn(page, "edge", 2.0);
        self.outline(page, points);
        drawn(page, "limb", 0.0);
    }

    /// Where the origin is, and the three axes with their names, beginning at a place on the page.
    fn axes(&self, page: &mut String, [x, y]: [f64; 2]) {
        let ([a, b], long) = (self.origin, 42.0);
        let _ = writeln!(page, "<path class=\"axis\" d=\"M{} {b}h10M{a} {}v10\"/>", a - 5.0, b - 5.0);
        for (dx, dy, name) in [(1.0, 0.0, NAMES[self.right]), (0.0, -1.0, NAMES[self.up])] {
            let (ex, ey) = (x + dx * long, y + dy * long);
            let (bx, by) = (ex - 7.0 * dx, ey - 7.0 * dy);
            let _ = writeln!(
                page,
                "<path class=\"axis\" d=\"M{x:.1} {y:.1}L{ex:.1} {ey:.1}M{:.1} {:.1}L{ex:.1} {ey:.1}L{:.1} {:.1}\"/>",
                bx + 4.0 * dy,
                by + 4.0 * dx,
                bx - 4.0 * dy,
                by - 4.0 * dx
            );
            let (tx, ty, anchor) =
                if dx > 0.0 { (ex + 5.0, ey + 4.0, "start") } else { (ex - 6.0, ey - 6.0, "start") };
            let _ = writeln!(
                page,
                "<text class=\"name\" x=\"{tx:.1}\" y=\"{ty:.1}\" text-anchor=\"{anchor}\">{name}</text>"
            );
        }
        // As one draws an arrow that is seen from its head, or from its tail.
        let _ = writeln!(page, "<circle class=\"axis\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\"/>");
        if self.toward > 0.0 {
            let _ = writeln!(page, "<circle class=\"tip\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2\"/>");
        } else {
            let (a, b, c, d) = (x - 4.2, y - 4.2, x + 4.2, y + 4.2);
            let _ = writeln!(
                page,
                "<path class=\"axis\" d=\"M{a:.1} {b:.1}L{c:.1} {d:.1}M{a:.1} {d:.1}L{c:.1} {b:.1}\"/>"
            );
        }
        let way = if self.toward > 0.0 { "toward you" } else { "away from you" };
        let _ = writeln!(
            page,
            "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\">{}: {way}</text>",
            x - 6.0,
            y + 22.0,
            NAMES[self.deep]
        );
    }

    /// The tactors of a layout: filled on the side that is seen, hollow behind.
    fn tactors(&self, page: &mut String, layout: &Layout, level: f64) {
        for tactor in &layout.tactors {
            let [x, y] = self.at(tactor.position[self.right], tactor.position[self.up]);
            let seen = tactor.position[self.deep] * self.toward >= level;
            let class = if seen { "tactor" } else { "behind" };
            let _ = writeln!(
                page,
                "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\"><title>{}</title></circle>",
                tactor.name
            );
        }
    }
}

const STYLE: &str = "text{font:12px 'Helvetica Neue',Helvetica,Arial,'Liberation Sans','DejaVu Sans',sans-serif;fill:#444}\
.title{font-size:15px;font-weight:600;fill:#111}.name{font-size:11px;fill:#0b5c8a}\
.page{fill:#fff}.body{fill:#ece7e1;stroke:#b8aea3}.limb,.edge{stroke-linecap:round}.limb{stroke:#ece7e1}.edge{stroke:#b8aea3}\
.axis{fill:none;stroke:#0b5c8a;stroke-width:1.6}.tip{fill:#0b5c8a}.tactor{fill:#c2410c}\
.behind{fill:none;stroke:#c2410c;stroke-width:1.2}\
@media (prefers-color-scheme:dark){text{fill:#bbb}.title{fill:#eee}.name{fill:#7cc4ee}.page{fill:#14171a}\
.body{fill:#2c2e31;stroke:#55585c}.limb{stroke:#2c2e31}.edge{stroke:#55585c}.axis{stroke:#7cc4ee}.tip{fill:#7cc4ee}.tactor{fill:#ff9a5c}.behind{stroke:#ff9a5c}}";

/// A point and its mirror image, as an outline goes down on the right and up on the left.
fn mirrored(right: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let left = right.iter().rev().map(|[x, y]| [-x, *y]);
    right.iter().copied().chain(left).collect()
}

fn picture() -> String {
    let mut page = String::new();
    let trunk = View { right: 0, up: 1, deep: 2, toward: -1.0, scale: 390.0, origin: [175.0, 330.0] };
    let neck = ([[0.0, 0.4], [0.0, 0.3]], 0.11);
    let torso = [
        [0.06, 0.3],
        [0.1, 0.285],
        [0.2, 0.28],
        [0.25, 0.2],
        [0.26, 0.0],
        [0.25, -0.14],
        [0.215, -0.14],
        [0.2, 0.0],
        [0.188, 0.13],
        [0.165, 0.05],
        [0.157, -0.1],
        [0.185, -0.2],
        [0.185, -0.27],
    ];
    trunk.grown(&mut page, &mirrored(&torso), &[neck, ([[0.0, 0.425], [0.0, 0.485]], 0.15)]);
    trunk.tactors(&mut page, &vest(), 0.0);
    trunk.axes(&mut page, [31.0, 450.0]);

    let waist = View { right: 0, up: 2, deep: 1, toward: 1.0, scale: 480.0, origin: [445.0, 250.0] };
    let turn = |n: i32| (f64::from(n) * std::f64::consts::TAU / 24.0).sin_cos();
    let round: Vec<[f64; 2]> =
        (0..24).map(turn).map(|(right, ahead)| [0.157 * right, 0.113 * ahead]).collect();
    waist.outline(&mut page, &round);
    waist.tactors(&mut page, &belt(8).unwrap(), 0.0);
    waist.axes(&mut page, [351.0, 450.0]);

    let arm = View { right: 0, up: 2, deep: 1, toward: 1.0, scale: 760.0, origin: [705.0, 320.0] };
    let skin = [[0.022, 0.165], [0.026, 0.13], [0.04, -0.06], [0.046, -0.13], [0.03, -0.14]];
    let fist = [
        ([[-0.012, 0.17], [-0.05, 0.215]], 0.02),
        ([[0.0, 0.175], [0.0, 0.2]], 0.075),
        ([[-0.012, 0.21], [-0.012, 0.262]], 0.05),
        ([[0.012, 0.21], [0.012, 0.25]], 0.05),
    ];
    arm.grown(&mut page, &mirrored(&skin), &fist);
    arm.tactors(&mut page, &sleeve(4, 6).unwrap(), 0.0);
    arm.axes(&mut page, [606.0, 450.0]);

    let palm = View { right: 0, up: 2, deep: 1, toward: 1.0, scale: 1550.0, origin: [975.0, 395.0] };
    let fingers = hand(Hand::Right);
    let of = |name: &str| fingers.tactors.iter().find(|tactor| tactor.name == name).unwrap().position;
    let mut limbs: Vec<([[f64; 2]; 2], f64)> = ["index", "middle", "ring", "little"]
        .map(|finger| {
            let [[a, _, b], [c, _, d]] = [of(&format!("{finger}-pad")), of(&format!("{finger}-tip"))];
            ([[a, b], [c, d]], 0.0175)
        })
        .into();
    let [a, _, b] = of("thumb-tip");
    limbs.push(([[-0.026, 0.045], [a, b]], 0.021));
    let skin = [
        [-0.03, -0.02],
        [-0.034, 0.02],
        [-0.046, 0.05],
        [-0.044, 0.112],
        [0.0, 0.117],
        [0.041, 0.108],
        [0.046, 0.05],
        [0.034, 0.02],
        [0.03, -0.02],
    ];
    palm.grown(&mut page, &skin, &limbs);
    // The palm looks down: all of them are underneath.
    palm.tactors(&mut page, &fingers, 1.0);
    palm.axes(&mut page, [841.0, 450.0]);

    for (x, title, lines) in [
        (
            25.0,
            "Trunk, from behind",
            ["A vest of 40, its back on this side;", "the origin (+) is the middle of the trunk"],
        ),
        (345.0, "Waist, from above", ["A belt of 8, with room for clothes;", "the origin is the middle"]),
        (
            600.0,
            "Forearm, held out ahead",
            ["From above: a sleeve of 4 rows of 6,", "palm down; hollow ones underneath"],
        ),
        (
            835.0,
            "Right hand, from above",
            ["Flat, palm down, tactors underneath;", "the origin is the wrist's crease"],
        ),
    ] {
        let _ = writeln!(page, "<text class=\"title\" x=\"{x}\" y=\"34\">{title}</text>");
        for (line, y) in lines.into_iter().zip([53, 69]) {
            let _ = writeln!(page, "<text x=\"{x}\" y=\"{y}\">{line}</text>");
        }
    }
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1100\" height=\"490\" viewBox=\"0 0 1100 490\" role=\"img\">\n\
         <title>Body coordinates</title>\n<desc>x goes to the wearer's right, y up, z ahead, on the trunk, the waist, the forearm and the hand, with the tactors of the layouts.</desc>\n\
         <style>{STYLE}</style>\n<rect class=\"page\" width=\"1100\" height=\"490\"/>\n{page}</svg>\n"
    )
}

#[test]
fn the_picture_of_body_coordinates_shows_the_layouts() {
    let (path, made) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/body.svg"), picture());
    if std::env::var_os("UPDATE_DOCS").is_some_and(|v| v == "1") {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == made, "docs/body.svg is out of date: UPDATE_DOCS=1 cargo test --test body");
    // What it says of the axes is how the layouts are named.
    for (layout, name, axis) in [
        (vest(), "right", 0),
        (vest(), "upper", 1),
        (vest(), "front", 2),
        (belt(8).unwrap(), "right-half", 0),
        (belt(8).unwrap(), "front-half", 2),
        (sleeve(4, 6).unwrap(), "right", 0),
        (sleeve(4, 6).unwrap(), "top", 1),
        (sleeve(4, 6).unwrap(), "hand-side", 2),
        (hand(Hand::Right), "tips", 2),
    ] {
        let group = layout.groups.iter().find(|group| group.name == name).unwrap();
        assert!(group.tactors.iter().all(|n| layout.tactors[*n].position[axis] > 0.0), "{name}");
    }
}
