//! WGSL that shaders share: a line `#import name` stands for the snippet of that name.

/// What may be imported, by name.
const SNIPPETS: [(&str, &str); 27] = [
    ("angle", include_str!("../lit/angle.wgsl")),
    ("aspect", include_str!("../methods/transfer_tensor/aspect.wgsl")),
    ("batch", include_str!("../methods/sphere_shadows/batch.wgsl")),
    ("brdf", include_str!("../lit/brdf.wgsl")),
    ("bytes", include_str!("bytes.wgsl")),
    ("corner", include_str!("../lit/corner.wgsl")),
    ("everywhere", include_str!("everywhere.wgsl")),
    ("filtered", include_str!("../methods/transfer_tensor/filtered.wgsl")),
    ("frame", include_str!("../methods/transfer_tensor/frame.wgsl")),
    ("harmonics", include_str!("../methods/transfer_tensor/harmonics.wgsl")),
    ("hemisphere", include_str!("../methods/transfer_tensor/hemisphere.wgsl")),
    ("invocation", include_str!("invocation.wgsl")),
    ("lobes", include_str!("../methods/sphere_shadows/lobes.wgsl")),
    ("material", include_str!("../lit/material.wgsl")),
    ("pi", include_str!("pi.wgsl")),
    ("places", include_str!("../methods/transfer_tensor/places.wgsl")),
    ("rows", include_str!("../methods/sphere_shadows/rows.wgsl")),
    ("spans", include_str!("../methods/sphere_shadows/spans.wgsl")),
    ("square", include_str!("../methods/sphere_shadows/square.wgsl")),
    ("sun", include_str!("../lit/sun.wgsl")),
    ("sunlight", include_str!("../lit/sunlight.wgsl")),
    ("surface", include_str!("../lit/surface.wgsl")),
    ("tables", include_str!("../methods/transfer_tensor/tables.wgsl")),
    ("texture", include_str!("../lit/texture.wgsl")),
    ("tile", include_str!("../methods/transfer_tensor/tile.wgsl")),
    ("triangle", include_str!("../methods/sphere_shadows/triangle.wgsl")),
    ("view", include_str!("../lit/view.wgsl")),
];

/// `source` with each snippet that it imports, or that these import, once and where it is first asked for. A
/// name that nothing is called stays as it is, which no compiler accepts.
pub(crate) fn expand(source: &str) -> String {
    let (mut expanded, mut imported) = (String::new(), Vec::new());
    add(source, &mut expanded, &mut imported);
    expanded
}

fn add<'a>(source: &'a str, expanded: &mut String, imported: &mut Vec<&'a str>) {
    for line in source.lines() {
        let name = line.strip_prefix("#import ").map(str::trim);
        match name.and_then(|name| SNIPPETS.iter().find(|(known, _)| *known == name)) {
            Some((name, _)) if imported.contains(name) => {}
            Some((name, snippet)) => {
                imported.push(name);
                add(snippet, expanded, imported);
            }
            None => {
                expanded.push_str(line);
                expanded.push('\n');
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use std::path::{Path, PathBuf};

    /// Every file below `folder` that ends in .wgsl.
    fn files(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                files(&path, found);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                found.push(path);
            }
        }
    }

    /// The text of every file of WGSL, with its path.
    fn texts() -> Vec<(PathBuf, String)> {
        let mut found = Vec::new();
        files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
        found.into_iter().map(|path| (path.clone(), std::fs::read_to_string(path).unwrap())).collect()
    }

    #[test]
    fn every_shader_is_valid_without_optional_features() {
        let texts = texts();
        assert!(texts.len() > SNIPPETS.len());
        for (path, text) in texts {
            let text = expand(&text);
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| {
                panic!("{}", e.emit_to_string_with_path(&text, &path.display().to_string()))
            });
            // `unpack2x16float` is part of WebGPU, though naga knows devices below it.
            Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32)
                .validate(&module)
                .unwrap_or_else(|e| {
                    panic!("{}", e.emit_to_string_with_path(&text, &path.display().to_string()))
                });
        }
    }

    #[test]
    fn every_snippet_is_shared() {
        for (name, snippet) in SNIPPETS {
            let users = texts()
                .iter()
                .filter(|(_, text)| text.lines().any(|line| line == format!("#import {name}")))
                .count();
            assert!(users >= 1, "nobody imports {name}");
            assert!(!snippet.is_empty() && SNIPPETS.iter().filter(|(other, _)| *other == name).count() == 1);
        }
    }

    #[test]
    fn no_function_or_struct_is_written_twice() {
        let mut seen = std::collections::BTreeMap::new();
        for (path, text) in texts() {
            for item in text.split("\n\n").filter(|item| {
                item.lines().count() > 2
                    && (item.contains("\nfn ") || item.starts_with("fn ") || item.contains("struct "))
            }) {
                // Without comments, and whatever the indentation.
                let code: Vec<&str> =
                    item.lines().map(str::trim).filter(|line| !line.starts_with("//")).collect();
                if let Some(other) = seen.insert(code.join("\n"), path.clone()) {
                    panic!("{} and {} share\n{item}", path.display(), other.display());
                }
            }
        }
    }

    #[test]
    fn imports_come_once_and_nest() {
        let text = expand("#import corner\n#import view\nfn f() {}\n");
        assert_eq!(text.matches("struct View {").count(), 1);
        assert!(
            text.find("struct View {") < text.find("fn on_film(")
                && text.find("fn on_film(") < text.find("fn f()")
        );
        assert_eq!(expand("#import nothing"), "#import nothing\n");
    }
}
