//! Inputs that went wrong once, each with its right outcome, by the commands that users type. The files are
//! in `inputs/<case>`.

mod bundles;
mod gltf;
mod import;
mod maps;
mod messages;
mod random_scenes;
mod robustness;
