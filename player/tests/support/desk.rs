//! A virtual display, and a player with a window on it that is worked with `xdotool`.

use egui::{Pos2, Rect};
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::CURRENT_TIME;
use x11rb::protocol::xproto::{ClientMessageEvent, ConnectionExt as _, EventMask, ImageFormat};

/// Longest wait for anything. Software rendering on a busy machine is slow.
const PATIENCE: Duration = Duration::from_secs(300);

/// A display of our own.
pub struct Display {
    server: Child,
    name: String,
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Display {
    /// A new display, or `None` aloud if this machine has no server for it.
    pub fn open() -> Option<Self> {
        if !crate::support::gpu_there(|| relume_player::gpu::list().map(|_| ()).map_err(|e| e.to_string()))
            || !crate::support::gpu_there(tools_there)
        {
            return None;
        }
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1600x1200x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        assert!(!number.trim().is_empty(), "Xvfb did not start");
        Some(Self { server, name: format!(":{}", number.trim()) })
    }

    /// What programs call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What `xdotool` says to these commands, one after the other; `None` if it fails.
    pub fn xdotool(&self, commands: &str) -> Option<String> {
        let output = Command::new("xdotool")
            .args(commands.split_whitespace())
            .env("DISPLAY", &self.name)
            .output()
            .unwrap();
        output.status.success().then(|| String::from_utf8(output.stdout).unwrap().trim().to_owned())
    }
}

fn tools_there() -> Result<(), String> {
    for (tool, package) in [("Xvfb", "xvfb"), ("xdotool", "xdotool")] {
        let found = std::env::var_os("PATH")
            .is_some_and(|path| std::env::split_paths(&path).any(|folder| folder.join(tool).exists()));
        if !found {
            return Err(format!("no {tool}; install {package}"));
        }
    }
    Ok(())
}

/// A player with a window. Files that it saves go into a folder of its own.
pub struct Window<'a> {
    pub display: &'a Display,
    pub child: Child,
    pub id: String,
    pub folder: tempfile::TempDir,
}

impl Drop for Window<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl<'a> Window<'a> {
    /// Plays `bundle`, and waits for a window whose title starts with `title`.
    pub fn open(display: &'a Display, bundle: &Path, arguments: &[&str], title: &str) -> Self {
        Self::open_among(display, bundle, arguments, title, &[])
    }

    /// Like [`Window::open`], with these variables in the environment.
    pub fn open_among(
        display: &'a Display,
        bundle: &Path,
        arguments: &[&str],
        title: &str,
        environment: &[(&str, &Path)],
    ) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let child = Command::new(env!("CARGO_BIN_EXE_player"))
            .arg(bundle)
            .args(arguments)
            .current_dir(folder.path())
            .env("DISPLAY", &display.name)
            .env("WINIT_X11_SCALE_FACTOR", "1")
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .envs(environment.iter().copied())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut window = Self { display, child, id: String::new(), folder };
        window.id = window.wait("a window", |window| {
            let search = format!("search --all --onlyvisible --pid {} --name Relume", window.child.id());
            let found = window.display.xdotool(&search)?;
            found.lines().next().map(str::to_owned).filter(|id| !id.is_empty())
        });
        window.wait_for_title(title);
        window.focus();
        window
    }

    /// Lets the keyboard write to this window.
    pub fn focus(&self) {
        self.display.xdotool(&format!("windowfocus --sync {}", self.id)).unwrap();
    }

    /// Asks it to close, as the button on a window's frame does.
    pub fn ask_to_close(&self) {
        let (connection, _) = x11rb::connect(Some(&self.display.name)).unwrap();
        let atom = |name: &[u8]| connection.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let (protocols, delete) = (atom(b"WM_PROTOCOLS"), atom(b"WM_DELETE_WINDOW"));
        let id = self.id.parse().unwrap();
        let message = ClientMessageEvent::new(32, id, protocols, [delete, CURRENT_TIME, 0, 0, 0]);
        connection.send_event(false, id, EventMask::NO_EVENT, message).unwrap().check().unwrap();
    }

    /// Waits until `look` finds something.
    #[track_caller]
    pub fn wait<T>(&mut self, what: &str, look: impl Fn(&Self) -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            if let Some(found) = look(self) {
                return found;
            }
            if let Some(status) = self.child.try_wait().unwrap() {
                panic!("waited for {what}, but the player ended: {status}, {}", self.complaint());
            }
            assert!(began.elapsed() < PATIENCE, "waited for {what} in vain; the title is {:?}", self.title());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    pub fn complaint(&mut self) -> String {
        self.child.stderr.take().map_or_else(String::new, |stderr| std::io::read_to_string(stderr).unwrap())
    }

    pub fn title(&self) -> Option<String> {
        self.display.xdotool(&format!("getwindowname {}", self.id))
    }

    #[track_caller]
    pub fn wait_for_title(&mut self, title: &str) {
        self.wait(title, |window| window.title().filter(|is| is.starts_with(title)));
    }

    /// Waits until a pixel of `rect` has a colour that `is_so` (red, green, blue).
    #[track_caller]
    pub fn wait_for_colour(&mut self, rect: Rect, is_so: impl Fn([u8; 3]) -> bool) {
        let (connection, _) = x11rb::connect(Some(&self.display.name)).unwrap();
        let id = self.id.parse().unwrap();
        let Rect { min, max } = rect.round();
        let (width, height) = ((max.x - min.x) as u16, (max.y - min.y) as u16);
        self.wait("a colour", |_| {
            let (x, y) = (min.x as i16, min.y as i16);
            let image = connection.get_image(ImageFormat::Z_PIXMAP, id, x, y, width, height, !0).ok()?;
            // Blue comes first, and the fourth byte means nothing.
            let data = image.reply().ok()?.data;
            data.chunks_exact(4).any(|bgr| is_so([bgr[2], bgr[1], bgr[0]])).then_some(())
        });
    }

    pub fn size(&self) -> [f32; 2] {
        let text = self.display.xdotool(&format!("getwindowgeometry --shell {}", self.id)).unwrap();
        ["WIDTH=", "HEIGHT="]
            .map(|key| text.lines().find_map(|line| line.strip_prefix(key)).unwrap().parse().unwrap())
    }

    pub fn click(&self, at: Pos2) {
        let Pos2 { x, y } = at.round();
        self.display.xdotool(&format!("mousemove --window {} {x} {y} click 1", self.id)).unwrap();
    }

    /// Drags with a button of the mouse, faster than any hand: on a slow display it is over before the next
    /// frame.
    pub fn drag(&self, button: u32, from: Pos2, to: Pos2) {
        let at =
            |point: Pos2| format!("mousemove --window {} {} {}", self.id, point.round().x, point.round().y);
        let (from, half, to) = (at(from), at(from + 0.5 * (to - from)), at(to));
        self.display.xdotool(&format!("{from} mousedown {button} {half} {to} mouseup {button}")).unwrap();
    }

    /// Clicks, and presses keys at once.
    pub fn click_and_type(&self, at: Pos2, keys: &str) {
        let Pos2 { x, y } = at.round();
        self.display
            .xdotool(&format!("mousemove --window {} {x} {y} click 1 key --delay 0 {keys}", self.id))
            .unwrap();
    }

    /// Presses keys, one after the other and without a pause.
    pub fn keys(&self, keys: &str) {
        self.display.xdotool(&format!("key --delay 0 {keys}")).unwrap();
    }

    /// Presses a key that saves, and waits for the file.
    #[track_caller]
    pub fn save(&mut self, key: &str, name: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        assert!(!path.exists());
        self.keys(key);
        self.saved(name)
    }

    /// Waits for a file that is being saved.
    #[track_caller]
    pub fn saved(&mut self, name: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        // A file is claimed empty before it is filled.
        self.wait(name, |_| path.metadata().ok().filter(|file| file.len() > 0));
        path
    }

    /// Asserts that nothing is set: asked for a state, it saves none. A picture is saved on the way.
    #[track_caller]
    pub fn expect_nothing_set(&mut self) {
        let (states, pictures) = (self.files("toml"), self.files("png"));
        // The picture that is saved after it tells that the state was asked for.
        self.keys("t s");
        self.wait("a picture", |window| Some(()).filter(|()| window.files("png") > pictures));
        assert_eq!(self.files("toml"), states);
    }

    /// How many files with this extension have been saved, or are being.
    fn files(&self, extension: &str) -> usize {
        let files = std::fs::read_dir(self.folder.path()).unwrap();
        files.filter(|file| file.as_ref().unwrap().path().extension().is_some_and(|e| e == extension)).count()
    }

    /// The statistics, once they are written.
    pub fn wait_for_stats(&mut self, path: &Path) -> serde_json::Value {
        let began = Instant::now();
        while !path.exists() {
            assert!(began.elapsed() < PATIENCE, "no statistics");
            std::thread::sleep(Duration::from_millis(20));
        }
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
    }

    /// Waits for the end: the exit code, and what was said on stderr.
    #[track_caller]
    pub fn end(mut self) -> (Option<i32>, String) {
        let began = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(began.elapsed() < PATIENCE, "the player does not end");
            std::thread::sleep(Duration::from_millis(20));
        };
        (status.code(), self.complaint())
    }
}
