use glam::DVec3;
use relume_bake::spheres::{ball::Ball, triangle_tree::TriangleTree};
fn main() {
    let text = std::fs::read_to_string(std::env::args().nth(1).unwrap()).unwrap();
    let (mut v, mut f) = (Vec::new(), Vec::new());
    for l in text.lines() {
        let w: Vec<&str> = l.split_whitespace().collect();
        if w.first() == Some(&"v") {
            v.push(DVec3::new(w[1].parse().unwrap(), w[2].parse().unwrap(), w[3].parse().unwrap()));
        }
        if w.first() == Some(&"f") {
            let i = |k: usize| w[k].split('/').next().unwrap().parse::<u32>().unwrap() - 1;
            f.push([i(1), i(2), i(3)]);
        }
    }
    let mesh = TriangleTree::new(v, f);
    let t = std::time::Instant::now();
    let mut s = 0.0;
    let n = 20000;
    for i in 0..n {
        let a = i as f64 * 0.001;
        let b = Ball::new(DVec3::new(a.cos(), 0.01, a.sin()), 0.30 + 0.1 * (i % 100) as f64 / 100.0);
        s += b.outside(&mesh).volume;
    }
    println!("outside {:.2} us {s}", t.elapsed().as_secs_f64() / n as f64 * 1e6);
}
