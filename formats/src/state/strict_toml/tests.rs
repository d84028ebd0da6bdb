use super::*;
use crate::state::State;

fn refused(text: &str) -> String {
    parse::<State>(text, &Place::file("s.toml")).unwrap_err().to_string()
}

#[test]
fn unknown_keys_name_line_column_and_what_was_meant() {
    for (text, expected) in [
        (
            "[materials.bunny]\nkd = [0.1, 0.1, 0.1]\nshinines = 3.0\n",
            "line 3, column 1: materials.bunny: unknown key `shinines`; did you mean `shininess`?",
        ),
        (
            "[materials.a]\nKD = [0.1, 0.1, 0.1]\n",
            "line 2, column 1: materials.a: unknown key `KD`; did you mean `kd`?",
        ),
        (
            "[materials.a]\ncolor = [0.1, 0.1, 0.1]\n",
            "line 2, column 1: materials.a: unknown key `color`; the colour of a material is `base_color` of ggx, `kd` of other models",
        ),
        ("[camera]\nfov = 3.0\n", "line 2, column 1: camera: unknown key `fov`; did you mean `fov_deg`?"),
        (
            "[camera]\nkd = [0.1, 0.1, 0.1]\n",
            "line 2, column 1: camera: unknown key `kd`; it belongs to [materials.NAME]",
        ),
        (
            "[materials.a]\nbrdf = \"ggx\"\n",
            "line 2, column 1: materials.a: a state cannot set `brdf` of a material, only scene.toml can, before the bake; there are: `kd`, `ks`, \
             `shininess`, `fresnel`, `base_color`, `metallic`, `roughness`",
        ),
        (
            "[lights.a]\nirradiance = [1, 1, 1]\n",
            "line 2, column 1: lights.a: a state cannot set `irradiance` of a light, only scene.toml can, before the bake; there are: `gain`",
        ),
        (
            "[environment]\nfile = \"a.hdr\"\n",
            "line 2, column 1: environment: a state cannot set `file` of the environment, only scene.toml can, before the bake; there are: `map`, \
             `rotation_deg`, `gain`",
        ),
        (
            "[shapes.a]\nmaterial = \"b\"\n",
            "line 2, column 1: shapes.a: a state cannot set `material` of a shape, only scene.toml can, before the bake; there are: `clip`, `time_s`, \
             `pose`",
        ),
        ("[lights.a]\nmap = 1\n", "line 2, column 1: lights.a: unknown key `map`; there are: `gain`"),
        ("[cammera]\n", "line 1, column 2: unknown key `cammera`; did you mean `camera`?"),
        (
            "[xyz]\n",
            "line 1, column 2: unknown key `xyz`; there are: `environment`, `camera`, `view`, `lights`, `materials`, `shapes`",
        ),
    ] {
        assert_eq!(refused(text), format!("s.toml: {expected}"));
    }
}

#[test]
fn what_no_method_supports_is_refused_as_what_it_is() {
    let models = "remove it, as materials are of the models \"blinn-phong\", \"ggx\" and \"cook-torrance\"";
    for (text, expected) in [
        (
            "[camera]\nfov_deg = 40\n[media.glass]\nindex = 1.5\n",
            "line 3, column 2: `media` is the refracting and scattering media within objects, which no method of this version supports; remove it, as surfaces are \
             opaque"
                .to_owned(),
        ),
        (
            "materials.a.brdf = \"mirror\"",
            format!("line 1, column 13: materials.a: \"mirror\" is a model of materials, which no method of this version supports; {models}"),
        ),
        (
            "materials.a.gloss_deg = 3",
            format!("line 1, column 13: materials.a: `gloss_deg` is the blur of the model \"mirror\", which no method of this version supports; {models}"),
        ),
        (
            "materials.a.fresnel = \"f.png\"",
            "line 1, column 23: materials.a.fresnel: \"f.png\" is a texture for `fresnel`, which is the same all over a material; write a number"
                .to_owned(),
        ),
        // Of other places and values there is nothing known.
        ("camera.media = 1", "line 1, column 8: camera: unknown key `media`; there are: `position`, `target`, `fov_deg`, `exposure_ev`".to_owned()),
        ("camera.fov_deg = \"s.exr\"", "line 1, column 18: camera.fov_deg: the text \"s.exr\" where a number is expected".to_owned()),
        ("materials.a.shininess = \"shiny\"", "line 1, column 25: materials.a.shininess: the text \"shiny\" where a number is expected".to_owned()),
    ] {
        assert_eq!(refused(text), format!("s.toml: {expected}"));
    }
}

#[test]
fn values_of_another_type_say_what_to_write() {
    for (text, expected) in [
        (
            "camera.fov_deg = \"40\"",
            "line 1, column 18: camera.fov_deg: the text \"40\" where a number is expected; write 40 without quotes",
        ),
        (
            "camera.fov_deg = \"40,5\"",
            "line 1, column 18: camera.fov_deg: the text \"40,5\" where a number is expected; write 40.5 without quotes",
        ),
        ("camera.fov_deg = true", "line 1, column 18: camera.fov_deg: true where a number is expected"),
        (
            "camera.fov_deg = 1979-05-27",
            "line 1, column 18: camera.fov_deg: the date 1979-05-27 where a number is expected",
        ),
        (
            "materials.a.kd = 0.6",
            "line 1, column 18: materials.a.kd: the number 0.6 where 3 numbers are expected; write [0.6, 0.6, 0.6]",
        ),
        (
            "materials.a.kd = \"#808080\"",
            "line 1, column 18: materials.a.kd: the text \"#808080\" where 3 numbers are expected; write [0.2159, 0.2159, 0.2159], the linear light that this colour stands for",
        ),
        (
            "materials.a.kd = [0.1, 0.2]",
            "line 1, column 18: materials.a.kd: 2 numbers where 3 are expected; add 1",
        ),
        (
            "materials.a.kd = [0.1, 0.2, 0.3, 1.0]",
            "line 1, column 18: materials.a.kd: 4 numbers where 3 are expected; remove 1",
        ),
        (
            "materials.a.kd = [0,5, 0,25, 0,1]",
            "line 1, column 18: materials.a.kd: 6 numbers where 3 are expected; if the commas within numbers are decimal, write [0.5, 0.25, 0.1]",
        ),
        (
            "materials.a.kd = [0.1, \"0.2\", 0.3]",
            "line 1, column 24: materials.a.kd: the text \"0.2\" where a number is expected; write 0.2 without quotes",
        ),
        (
            "materials.kd = [0.1, 0.2, 0.3]",
            "line 1, column 16: materials.kd: a list of 3 where a table is expected; write [materials.NAME] above the keys",
        ),
        (
            "[[materials]]\nkd = [0.1, 0.2, 0.3]",
            "line 1, column 1: materials: a list of tables where a table for each name is expected; write [materials.NAME]",
        ),
        (
            "[[camera]]\nfov_deg = 3",
            "line 1, column 1: camera: a list of tables where one table is expected; write [camera], with one bracket",
        ),
        (
            "camera = 3",
            "line 1, column 10: camera: the number 3 where a table is expected; write [camera] above its keys",
        ),
        (
            "environment.map = 3",
            "line 1, column 19: environment.map: the number 3 where a text is expected; write \"3\" with quotes",
        ),
    ] {
        assert_eq!(refused(text), format!("s.toml: {expected}"));
    }
}

#[test]
fn what_is_no_toml_is_mended_where_the_mistake_is_a_common_one() {
    for (text, expected) in [
        (
            "camera.fov_deg = 40,0\n",
            "line 1, column 18: camera.fov_deg: `40,0` is no value; write 40.0, with a decimal point",
        ),
        ("\ncamera.fov_deg = .5\n", "line 2, column 18: camera.fov_deg: `.5` is no value; write 0.5"),
        ("camera.fov_deg = -5.\n", "line 1, column 18: camera.fov_deg: `-5.` is no value; write -5.0"),
        (
            "camera.fov_deg = 40;\n",
            "line 1, column 18: camera.fov_deg: `40;` is no value; write 40, without the sign at its end",
        ),
        (
            "environment.map = studio.exr\n",
            "line 1, column 19: environment.map: `studio.exr` is no value; write \"studio.exr\" with quotes",
        ),
        (
            "environment.map = “a.exr”\n",
            "line 1, column 19: `“` is a typographic quotation mark; write \" instead",
        ),
        ("camera.fov_deg = −5\n", "line 1, column 18: `−` is a typographic dash; write - instead"),
        ("camera.fov_deg: 40\n", "line 1, column 15: `:` after `camera.fov_deg`; write camera.fov_deg = 40"),
        (
            "materials.a.kd = #808080\n",
            "line 1, column 18: materials.a.kd: `#` begins a comment; write [0.2159, 0.2159, 0.2159], the linear light that this colour stands for",
        ),
        (
            "[materials.Box Paint]\n",
            "line 1, column 1: the name `Box Paint` has more than letters, digits, - and _; write [materials.\"Box Paint\"]",
        ),
        (
            "camera.fov_deg =\n",
            "line 1, column 17: camera.fov_deg: nothing is no value; write one after the `=`",
        ),
        (
            "[light]\na = 1\n[light]\nb = 1\n",
            "line 3, column 2: [light] stands for one table where there are several; write [[light]] above each, with two brackets",
        ),
        ("[camera]\n[camera]\n", "line 2, column 2: [camera] is there twice; put the keys of both into one"),
        (
            "camera.fov_deg = 4\ncamera.fov_deg = 5\n",
            "line 2, column 8: `fov_deg` is there twice; remove one",
        ),
    ] {
        assert_eq!(refused(text), format!("s.toml: {expected}"));
    }
}

#[test]
fn text_of_other_encodings_is_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_text(&path).map_err(|e| e.to_string().replace(&format!("{}: ", path.display()), ""))
    };
    assert_eq!(read(b"\xef\xbb\xbf\tcamera.fov_deg = 40\r\n").unwrap(), "\tcamera.fov_deg = 40\r\n");
    assert_eq!(
        read(b"\xff\xfe[\0").unwrap_err(),
        "not a text file of UTF-8, but of UTF-16; save it as UTF-8"
    );
    assert_eq!(read(b"[\0c\0").unwrap_err(), "not a text file of UTF-8, but of UTF-16; save it as UTF-8");
    let latin = "line 2, column 4: not a text file of UTF-8: byte 0xFC belongs to another encoding, such as Latin-1; save it as UTF-8";
    assert_eq!(read(b"a = 1\n# B\xfcro\n").unwrap_err(), latin);
    assert_eq!(read(b"\0\0\0\x02\xff").unwrap_err(), "not a text file (byte 4 is not UTF-8)");
}

#[test]
fn a_message_gets_the_line_of_what_it_speaks_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = "[vary]\nmaterials = [\"a\"]\n[render]\nsize = [0, 5]\n[materials.b]\nkd = [0, 0, 0]\n[materials.a]\nroughness = 0.1\n\
                [[object]]\nname = \"ball\"\nmaterial = \"wal\"\n[[object]]\nname = \"box\"\nfile = \"gone.obj\"\n[[key]]\nt_s = 2\nmaterials.a.kd = [1, 1, 1]\n";
    std::fs::write(&path, text).unwrap();
    for (part, reason, expected) in [
        ("[render]", "size [0, 5] is outside", "line 4: [render]"),
        ("material `a`", "roughness 0.1 is outside", "line 8: material `a`"),
        ("material `a`", "is a bad one", "line 7: material `a`"),
        ("object `ball`", "no material `wal`", "line 11: object `ball`"),
        ("object `box`", "no such file: `gone.obj`", "line 14: object `box`"),
        ("object `box`", "is flat", "line 12: object `box`"),
        ("material `a`", "has kd, not `roughness`", "line 8: material `a`"),
        ("somewhere", "there is no `gone.obj`", "line 14: somewhere"),
        ("elsewhere", "two objects are called `box`", "line 12: elsewhere"),
        ("at 2 s", "material `a`: kd + ks", "line 17: at 2 s"),
        ("elsewhere", "nothing is known", "elsewhere"),
        ("line 3, column 1", "material `a`", "line 3, column 1"),
    ] {
        let error = with_line(Error::invalid(&Place::file(&path).part(part), reason));
        assert_eq!(error.to_string(), format!("{}: {expected}: {reason}", path.display()));
    }
}

/// Named members of lists, and texts in lists, before words that are keys of something else.
#[test]
fn messages_are_told_at_the_line_that_they_speak_of() {
    let text = "[environment]\nfile = 'white'\nothers = ['sky', 'nope.exr']\n[vary]\nmaterials = ['clay']\n\
        [materials.clay]\nks = [1, 1, 1]\n[[light]]\nname = 'sun'\nkind = 'directional'\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    for (part, reason, line) in [
        ("light `sun`", "lights by the environment alone, a file of which is baked", 8),
        ("[environment]", "no such file: `nope.exr`", 3),
        ("[environment]", "two environment maps are called `white`", 2),
        ("material `clay`", "ks [1.0, 1.0, 1.0] is too much", 7),
        ("[vary] materials", "`clay` is listed twice; remove one", 5),
    ] {
        let told = with_line(Error::invalid(&Place::file(&path).part(part), reason)).to_string();
        assert!(told.contains(&format!("scene.toml: line {line}: {part}: ")), "{told}");
    }
}
