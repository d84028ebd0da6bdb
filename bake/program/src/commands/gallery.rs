//! `bake gallery`.

use super::common::{SAME_COMMAND, load, start_threads};
use crate::cli::GalleryArgs;
use relume_bake::error::Result;
use relume_bake::job::{Job, watch_signals};
use relume_bake::unfinished::FolderLock;
use relume_chart::chart::{self, FOLDER};
use relume_chart::gallery;
use relume_formats::Place;
use std::path::Path;

/// `bake gallery`.
pub fn gallery(args: &GalleryArgs) -> Result<String> {
    watch_signals()?;
    start_threads(args.threads)?;
    let scenes = if args.scene.is_empty() { gallery::scenes(chart::expect_fit)? } else { args.scene.clone() };
    let job = Job::new(args.progress);
    let chart = |scene: &str| {
        let scene = load(scene)?;
        gallery::expect_plain(&scene.name, &Place::file(&scene.file))?;
        let folder = Path::new(FOLDER).join(&scene.name);
        chart::run(&scene, &[], &folder, &job)
            .map_err(|e| e.kept(chart::holds_work(&folder), SAME_COMMAND))?;
        Ok(folder)
    };
    let _lock = FolderLock::take(&args.output)?;
    gallery::make(&scenes, &args.output, chart)
}
