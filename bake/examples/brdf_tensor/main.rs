//! Tensors of BRDF spaces, and the figures of docs/notes/TRANSFER-TENSOR.md:
//!
//! `cargo run --release --example brdf_tensor -- make MODEL -o FILE.relume`
//!
//! `cargo run --release --example brdf_tensor -- figures MODEL`

mod figures;

use relume_bake::brdf::tensor::make;
use relume_formats::container::Stored as _;
use relume_formats::state::Model;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

const USAGE: &str = "usage: brdf_tensor make MODEL -o FILE.relume | figures MODEL, \
    MODEL one of blinn-phong, ggx, cook-torrance";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["make", model, "-o", file] => write(named(model)?, Path::new(file)),
        ["figures", model] => figures::print(named(model)?),
        _ => Err(USAGE.into()),
    }
}

fn named(name: &str) -> Result<Model, Box<dyn Error>> {
    let models = [Model::BlinnPhong, Model::Ggx, Model::CookTorrance];
    models.into_iter().find(|model| model.name() == name).ok_or_else(|| USAGE.into())
}

fn write(model: Model, file: &Path) -> Result<(), Box<dyn Error>> {
    let started = Instant::now();
    make(model)?.write_file(file)?;
    println!("{}: {:.1} s", file.display(), started.elapsed().as_secs_f64());
    Ok(())
}
