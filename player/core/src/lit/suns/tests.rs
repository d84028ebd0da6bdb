//! What suns see, against the box around points.

use super::*;
use crate::testing::{gpu, read_values};

const ROTATIONS_DEG: [f32; 3] = [0.0, 33.0, 270.0];

fn suns() -> Vec<(Sun, f32)> {
    let directions =
        [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.48, -0.64), Vec3::new(0.0, 0.9999, 0.0141)];
    let sun = |direction: Vec3| Sun { direction: direction.normalize(), radius: 0.01, irradiance: [1.0; 3] };
    directions.into_iter().flat_map(|d| ROTATIONS_DEG.map(|rotation_deg| (sun(d), rotation_deg))).collect()
}

/// What the GPU makes of four suns at a time for vertices at `points`.
fn seen(gpu: &Gpu, points: &[Vec3], suns: &[(Sun, f32)]) -> Vec<gpu_data::Sun> {
    let points: Vec<[f32; 3]> = points.iter().map(|point| point.to_array()).collect();
    // As large as the mesh's: bindings are never empty.
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
    let positions = gpu.buffer("positions", size_of_val(&points[..]) as u64, usage);
    gpu.write(&positions, 0, bytemuck::cast_slice(&points));
    let uniform = gpu.buffer("suns", size_of::<gpu_data::Suns>() as u64, usage);
    let extent = Extent::new(gpu, &positions, &uniform);
    let of = |suns: &[(Sun, f32)]| {
        let mut data = gpu_data::Suns { count: suns.len() as u32, ..bytemuck::Zeroable::zeroed() };
        for (place, (sun, rotation_deg)) in data.suns.iter_mut().zip(suns) {
            *place = facing(sun, *rotation_deg);
        }
        gpu.write(&uniform, 0, bytemuck::bytes_of(&data));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut passes = Passes::new(&mut encoder, None, 0);
        extent.encode(&mut passes);
        passes.finish();
        gpu.queue.submit([encoder.finish()]);
        read_values::<gpu_data::Suns>(gpu, &uniform)[0].suns[..suns.len()].to_vec()
    };
    suns.chunks(MAX_SUNS).flat_map(of).collect()
}

#[test]
fn the_box_seen_from_a_sun_holds_all_corners_and_little_more() {
    let Some(mut gpu) = gpu() else { return };
    let mut points = vec![Vec3::new(-1.0, 2.0, 5.0), Vec3::new(3.0, 2.5, 5.5), Vec3::new(0.0, 2.2, 9.0)];
    let (centre, reach) = (Vec3::new(1.0, 2.25, 7.0), Vec3::new(2.0, 0.25, 2.0));
    // Some workgroups full within it, so that those of the extremes are among others.
    points.splice(
        1..1,
        (0..300)
            .map(|k| centre + 0.9 * reach * (Vec3::splat(k as f32) * Vec3::new(1.0, 2.0, 3.0)).map(f32::sin)),
    );
    for workgroups in [65535, 2] {
        gpu.workgroups_per_dimension = workgroups;
        for seen in seen(&gpu, &points, &suns()) {
            assert_eq!(Vec3::from(seen.centre), centre);
            let axes = [seen.right, seen.up, seen.towards].map(Vec3::from);
            let right_handed = axes[0].cross(axes[1]).dot(axes[2]);
            assert!((right_handed - 1.0).abs() < 1e-5 && axes.iter().all(|a| a.is_normalized()));
            for (axis, half) in axes.iter().zip([seen.half_width, seen.half_height, seen.half_depth]) {
                let along = axis.abs().dot(reach);
                // The margin is of 1/256.
                assert!(half >= along && half <= 1.005 * along.max(2.1e-3), "{along} {half}");
            }
        }
    }
}

#[test]
fn scenes_without_extent_have_a_box() {
    let Some(gpu) = gpu() else { return };
    for points in [&[][..], &[Vec3::splat(-7.0)], &[Vec3::splat(7.0); 70]] {
        for seen in seen(&gpu, points, &suns()) {
            assert_eq!(Vec3::from(seen.centre), points.first().copied().unwrap_or_default());
            assert!([seen.half_width, seen.half_height, seen.half_depth].iter().all(|half| *half > 0.0));
        }
    }
}
