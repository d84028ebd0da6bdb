//! temporary
#![allow(missing_docs)]
use relume_scenes_fuzz::Stage;
use std::panic::{catch_unwind, AssertUnwindSafe};
fn main() {
    let secs: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let mut s: u64 = std::env::args().nth(2).unwrap().parse().unwrap();
    let mut rnd = move || { s ^= s << 13; s ^= s >> 7; s ^= s << 17; s };
    let whole = |file: &str| format!("[[object]]\nname = \"a\"\nfile = \"{file}\"\nlights = true\n");
    let targets = [
        ("obj", "mesh.obj", Stage::of_mesh("obj", "mesh.obj"), 0), ("ply", "mesh.ply", Stage::of_mesh("ply", "mesh.ply"), 0), ("off", "mesh.off", Stage::of_mesh("off", "mesh.off"), 0),
        ("environment_hdr", "sky.hdr", Stage::new("hdr", "[environment]\nfile = \"sky.hdr\"\n"), 0),
        ("environment_exr", "sky.exr", Stage::new("exr", "[environment]\nfile = \"sky.exr\"\n"), 0),
        ("texture", "paint.png", Stage::new("texture", "[materials.a]\nkd = [0.5, 0.5, 0.5]\ntexture = \"paint.png\"\n[[object]]\nname = \"a\"\nmaterial = \"a\"\nshape = \"quad\"\n"), 0),
        ("gltf", "mesh.gltf", Stage::new("wg", &whole("mesh.gltf")), 1), ("gltf", "mesh.glb", Stage::new("wb", &whole("mesh.glb")), 1),
    ];
    for (t, file, stage, skip) in &targets {
        let seeds: Vec<Vec<u8>> = std::fs::read_dir(format!("scenes/fuzz/corpus/{t}")).unwrap().map(|e| std::fs::read(e.unwrap().path()).unwrap()[*skip..].to_vec())
            .filter(|b| *t != "gltf" || b.starts_with(b"glTF") == file.ends_with("glb")).collect();
        let end = std::time::Instant::now() + std::time::Duration::from_secs(secs);
        let (mut n, mut crashes, mut slow) = (0u64, 0, 0.0f64);
        for b in &seeds { stage.write(file, b); stage.load(); }
        while std::time::Instant::now() < end && crashes < 5 {
            let mut b = seeds[(rnd() % seeds.len() as u64) as usize].clone();
            for _ in 0..1 + rnd() % 6 {
                if b.is_empty() { break }
                let at = (rnd() % b.len() as u64) as usize;
                match rnd() % 7 {
                    0 => b[at] = rnd() as u8,
                    1 => b[at] ^= 1 << (rnd() % 8),
                    2 => { b.remove(at); }
                    3 => b.insert(at, b"0123456789-.e ,\n\"{}[]"[(rnd() % 22) as usize]),
                    4 => b.truncate(at),
                    5 => { let len = (1 + rnd() % 16) as usize; let from = (rnd() % b.len() as u64) as usize; let piece: Vec<u8> = b[from..(from + len).min(b.len())].to_vec(); b.splice(at..at, piece); }
                    _ => { let w = [0u32, 1, u32::MAX, 0x7fff_ffff, 0x7fc0_0000, 0x7f80_0000, 65535][(rnd() % 7) as usize].to_le_bytes(); for (i, v) in w.iter().enumerate() { if at + i < b.len() { b[at + i] = *v } } }
                }
            }
            let start = std::time::Instant::now();
            stage.write(file, &b);
            if catch_unwind(AssertUnwindSafe(|| stage.load())).is_err() { crashes += 1; std::fs::write(format!("/tmp/smoke-{t}-{crashes}-{file}"), &b).unwrap(); }
            let s = start.elapsed().as_secs_f64();
            if s > slow { slow = s; if s > 1.0 { std::fs::write(format!("/tmp/smoke-slow-{t}-{file}"), &b).unwrap(); } }
            n += 1;
        }
        println!("{t} {file}: {n} runs, {crashes} crashes, slowest {slow:.2} s");
    }
}
