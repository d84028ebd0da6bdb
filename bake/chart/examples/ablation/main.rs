//! Which approximation of a method is to blame for what, and what takes the error away that no more terms,
//! triangles or bases buy off: the tables of docs/CHART.md. A scene takes minutes; bunny-plane and fox-walk need
//! the assets (`make assets`):
//!
//! `cargo build --release --workspace && cargo run --release --example ablation --
//! cornell-knot|knot-outdoors|bunny-plane|knot-twist|fox-walk`

mod sparse_transfer;
mod sphere_shadows;
mod steps;
mod suns;
mod transfer_images;

use relume_bake::error::BakeError;
use relume_formats::Place;
use std::process::ExitCode;

fn main() -> ExitCode {
    let printed = match std::env::args().nth(1).as_deref() {
        Some(scene @ "cornell-knot") => transfer_images::ablation(scene),
        Some(scene @ ("knot-outdoors" | "bunny-plane")) => sparse_transfer::ablation(scene),
        Some(scene @ ("knot-twist" | "fox-walk")) => sphere_shadows::ablation(scene),
        _ => Err(BakeError::invalid(
            &Place::file("SCENE"),
            "give cornell-knot, knot-outdoors, bunny-plane, knot-twist or fox-walk",
        )),
    };
    let Err(error) = printed else { return ExitCode::SUCCESS };
    eprintln!("error: {error}");
    ExitCode::from(error.exit_code())
}
