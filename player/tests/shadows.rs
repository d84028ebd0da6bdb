//! The binary plays bundles of sphere-shadows, on the GPU and on the CPU.

use crate::run::{expect_error, expect_success, gpu_there, headless, player, stats};
use crate::support::{Bundle, shadows};

#[test]
fn shadows_play_on_either_adapter() {
    if !gpu_there() {
        return;
    }
    let bundle = shadows::Bundle::write(true);
    let pose = "duration_s = 1.0\n[[key]]\nt_s = 0\nshapes.worm = { clip = \"Turn\", time_s = 0.0 }\n[[key]]\nt_s = 1\nshapes.worm.time_s = 0.9\n\
                environment.rotation_deg = 90.0\n";
    std::fs::write(bundle.folder().join("pose.toml"), pose).unwrap();
    let play = |name: &str, more: &[&str]| {
        let frames = format!("@/{name}-%d.png");
        let arguments = [
            &["--frames", frames.as_str(), "--animation", "@/pose.toml", "--fps", "3", "--stats", "@/s.json"],
            more,
        ]
        .concat();
        expect_success(&headless(bundle.folder(), &arguments));
        let stats = stats(&bundle.folder().join("s.json"));
        assert_eq!(
            (&stats["method"], &stats["frames"], &stats["pieces_arrived"]),
            (&"sphere-shadows".into(), &3.into(), &1.into())
        );
        assert_eq!(stats["bytes_streamed"].as_u64().unwrap(), bundle.bytes());
        let frame = |i: usize| {
            image::open(bundle.folder().join(format!("{name}-{i}.png"))).unwrap().to_rgb8().into_raw()
        };
        (stats["adapter"].as_str().unwrap().to_owned(), [0, 1, 2].map(frame))
    };
    let list = String::from_utf8(player(&["--list-adapters"]).stdout).unwrap();
    let (first, _) = list.split_once(" [").unwrap();
    let ((named, gpu), (adapter, cpu)) =
        (play("gpu", &["--adapter", first]), play("cpu", &["--adapter", "cpu"]));
    assert_eq!(named, first);
    assert!(adapter.starts_with("cpu (") && adapter.ends_with(" draws)"), "{adapter}");
    // What nobody has named sums where it is faster.
    let (unnamed, _) = play("any", &[]);
    let is_software = list.lines().next().unwrap().contains("[CPU,");
    assert_eq!(unnamed, if is_software { adapter } else { named });
    assert!(gpu[0] != gpu[1] && gpu[1] != gpu[2]);
    for (gpu, cpu) in gpu.iter().zip(&cpu) {
        // One step at roundings, and a little more where a texel is on the rim of a cap.
        let off = gpu.iter().zip(cpu).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(off <= 3, "{off}");
    }
    // It plays from the whole of its files.
    let short =
        headless(bundle.folder(), &["--frames", "@/f.png", "--bytes", &(bundle.bytes() - 1).to_string()]);
    expect_error(&short, 2, &format!("give at least {}", bundle.bytes()));
    let images = Bundle::write(true);
    expect_error(
        &headless(images.folder(), &["--frames", "@/f.png", "--adapter", "cpu"]),
        2,
        "is for the method sphere-shadows, not transfer-images",
    );
    assert!(list.lines().any(|line| line.starts_with("cpu [radiance of sphere-shadows on all cores")));
}
