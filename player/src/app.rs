//! The window: what happens to it, when to draw, and when to sleep.
//!
//! Nothing is drawn unless something has changed: input, pieces that arrive, time that passes in an
//! animation. Between such events the program waits in the system's event queue.

mod canvas;
mod dialog;
mod dropped;

use crate::cli::Cli;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::headless::{WHAT_TO_ADD, request};
use crate::interrupt::Interrupt;
use crate::live::{Live, Outcome};
use crate::output::write_whole;
use crate::session::Session;
use crate::ui::{self, Note, Save, Screen, Wishes};
use canvas::{Canvas, Drawing, Painted};
use dropped::{Opening, Playing};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// While an animation plays, longest time from one frame of the window to the next, even if its picture takes
/// longer.
const FRAME_PAUSE: Duration = Duration::from_millis(33);

/// What wakes the window.
enum Wake {
    /// The user wants to stop.
    Interrupt,
    /// There is news of the picture.
    News,
    /// A file was chosen, or why none can be.
    Chosen(dialog::Chosen),
}

/// Plays as `cli` says in a window, until it is closed or `interrupt` is raised.
pub fn play(cli: &Cli, interrupt: &Interrupt) -> Result<()> {
    let started = Instant::now();
    check_usage(cli)?;
    let event_loop = event_loop()?;
    let (proxy, for_news) = (event_loop.create_proxy(), event_loop.create_proxy());
    interrupt.on_raise(move || {
        // A loop that has ended needs no waking.
        let _ = proxy.send_event(Wake::Interrupt);
    });
    let mut app = App { cli, interrupt, started, for_news, open: None, failure: None };
    event_loop.run_app(&mut app).map_err(|e| Error::Failed(format!("the display failed: {e}")))?;
    app.finish()
}

fn check_usage(cli: &Cli) -> Result<()> {
    let for_files = [
        ("--frames", cli.frames.is_some()),
        ("--exr", cli.exr.is_some()),
        ("--contact-sheet", cli.contact_sheet.is_some()),
        ("--count", cli.count.is_some()),
        ("--fps", cli.fps.is_some()),
    ];
    match for_files.iter().find(|(_, given)| *given) {
        Some((option, _)) => {
            Err(Error::Usage(format!("{option} is for playing without a window; add --headless")))
        }
        None => Ok(()),
    }
}

fn no_display(reason: &str) -> Error {
    Error::Usage(format!("no display{reason}; add --headless and {WHAT_TO_ADD}"))
}

fn event_loop() -> Result<EventLoop<Wake>> {
    if cfg!(all(unix, not(target_vendor = "apple"))) {
        let named = |variable| std::env::var_os(variable).is_some_and(|value| !value.is_empty());
        if !["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(named) {
            return Err(no_display(""));
        }
    }
    EventLoop::with_user_event().build().map_err(|e| no_display(&format!(" ({e})")))
}

/// The program while its event loop runs.
struct App<'a> {
    cli: &'a Cli,
    interrupt: &'a Interrupt,
    started: Instant,
    for_news: EventLoopProxy<Wake>,
    open: Option<Open>,
    failure: Option<Error>,
}

/// The window and what is in it.
struct Open {
    window: Arc<Window>,
    /// As the window last reported it. One that is destroyed cannot be asked any more, and winit panics if it
    /// is.
    size: PhysicalSize<u32>,
    gpu: Gpu,
    canvas: Canvas,
    live: Live,
    playing: Playing,
    /// Another bundle, until there is anything to see of it.
    opening: Option<Opening>,
    /// Whether a dialog for choosing a file is open.
    choosing: bool,
    /// Whether `--stats` is to be written.
    records: bool,
    for_news: EventLoopProxy<Wake>,
    input: egui_winit::State,
    screen: Screen,
    picture: Option<egui::TextureId>,
    title: String,
    note: Option<Note>,
    /// Whether the window was asked to close since the last frame: what was done before comes first.
    close_requested: bool,
    opened: Instant,
    /// When the last frame of a running animation was drawn.
    played_at: Option<Instant>,
    /// When egui wants to be drawn again.
    next_draw: Option<Instant>,
}

impl ApplicationHandler<Wake> for App<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.open.is_none() && !self.stops(event_loop) {
            match Open::new(event_loop, self.cli, self.started, self.for_news.clone()) {
                Ok(open) => self.open = Some(open),
                Err(error) => self.fail(event_loop, error),
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = self.open.as_mut().filter(|_| !event_loop.exiting()) else { return };
        let repaint = open.input.on_window_event(&open.window, &event).repaint;
        if repaint && !matches!(event, WindowEvent::RedrawRequested) {
            open.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => {
                open.close_requested = true;
                open.window.request_redraw();
            }
            WindowEvent::Destroyed => event_loop.exit(),
            WindowEvent::DroppedFile(path) => open.dropped(&path),
            WindowEvent::Resized(size) => open.resized(size),
            WindowEvent::Occluded(false) => open.window.request_redraw(),
            WindowEvent::RedrawRequested => match open.redraw() {
                Ok(true) => event_loop.exit(),
                Ok(false) => {}
                Err(error) => {
                    let error = open.rescued(error);
                    self.fail(event_loop, error);
                }
            },
            _ => {}
        }
    }

    fn user_event(&mut self, event_loop: &ActiveEventLoop, wake: Wake) {
        match (wake, &mut self.open) {
            (Wake::News, Some(open)) => open.take_news(event_loop),
            (Wake::Chosen(chosen), Some(open)) => open.chosen(chosen),
            _ => drop(self.stops(event_loop)),
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if event_loop.exiting() || self.stops(event_loop) {
            return;
        }
        let Some(open) = &mut self.open else { return };
        event_loop.set_control_flow(open.next_look().map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

impl App<'_> {
    /// Ends the loop if the user asked for that.
    fn stops(&mut self, event_loop: &ActiveEventLoop) -> bool {
        let stops = self.interrupt.is_raised();
        if stops {
            self.fail(event_loop, Error::Interrupted);
        }
        stops
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: Error) {
        self.failure.get_or_insert(error);
        event_loop.exit();
    }

    fn finish(self) -> Result<()> {
        let Some(open) = self.open else { return self.failure.map_or(Ok(()), Err) };
        let Outcome { statistics, ended } = open.live.end();
        let written = match (&self.cli.stats, statistics) {
            (Some(path), Some(statistics)) => write_whole(path, &statistics),
            _ => Ok(()),
        };
        self.failure.map_or(Ok(()), Err).and(written).and(ended)
    }
}

impl Open {
    fn new(
        event_loop: &ActiveEventLoop,
        cli: &Cli,
        started: Instant,
        for_news: EventLoopProxy<Wake>,
    ) -> Result<Self> {
        let mut parts = None;
        let session = Session::start(request(cli)?, || {
            let (gpu, window, instance, surface) = open_window(event_loop, cli)?;
            let for_picture = gpu.again()?;
            parts = Some((gpu, window, instance, surface));
            Ok(for_picture)
        })?;
        let Some((gpu, window, instance, surface)) = parts else {
            return Err(Error::Failed("no window was opened".to_owned()));
        };
        let canvas = Canvas::new(&gpu, window.clone(), instance, surface)?;
        let context = egui::Context::default();
        ui::set_up_style(&context);
        let texture_side = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(
            context,
            egui::ViewportId::ROOT,
            event_loop,
            scale,
            window.theme(),
            Some(texture_side),
        );
        window.set_visible(true);
        window.request_redraw();
        Ok(Self {
            live: Live::start(session, started, cli.stats.is_some(), waking(&for_news))?,
            playing: Playing::of(cli),
            opening: None,
            choosing: false,
            records: cli.stats.is_some(),
            for_news,
            gpu,
            size: window.inner_size(),
            window,
            canvas,
            input,
            screen: Screen::default(),
            picture: None,
            title: String::new(),
            note: None,
            close_requested: false,
            opened: started,
            played_at: None,
            next_draw: None,
        })
    }

    /// Takes in what there is to know of the picture.
    fn take_news(&mut self, event_loop: &ActiveEventLoop) {
        if self.live.take_news() {
            self.note = self.live.take_note().or_else(|| self.note.take());
            self.window.request_redraw();
        }
        self.look_at_opening();
        if self.live.is_hopeless() {
            event_loop.exit();
        }
    }

    /// The failure of the window itself, which ends the program, after the edits were saved that would be
    /// lost to it.
    fn rescued(&mut self, error: Error) -> Error {
        let edited = self.live.shown().is_some_and(|shown| shown.editor.unsaved().is_some());
        let saved = if edited { self.live.save(Save::State, Path::new("")) } else { Ok(None) };
        match saved {
            Ok(Some(path)) => Error::Failed(format!("{error}; your edits are saved in {}", path.display())),
            _ => error,
        }
    }

    /// Asks to be drawn if it is time. Returns when to look again.
    fn next_look(&mut self) -> Option<Instant> {
        let now = Instant::now();
        let due = [self.next_draw, self.played_at.map(|at| at + FRAME_PAUSE)].into_iter().flatten().min();
        if due.is_some_and(|due| due <= now) {
            self.window.request_redraw();
        }
        due.filter(|due| *due > now)
    }

    /// Draws a frame of the window, with the newest picture that there is. Returns whether the window is to
    /// be closed.
    fn redraw(&mut self) -> Result<bool> {
        self.pass_time();
        let (drawing, close) = self.draw_ui();
        self.live.order();
        match self.canvas.paint(&self.gpu, self.size, &drawing) {
            Painted::Yes => {}
            Painted::TryAgain => self.window.request_redraw(),
            Painted::WindowGone => return Ok(true),
        }
        self.gpu.poll()?;
        if std::mem::take(&mut self.close_requested) {
            self.screen.close();
            self.window.request_redraw();
        }
        self.set_title();
        Ok(close)
    }

    /// Lets the animation go on by the time since the last frame.
    fn pass_time(&mut self) {
        let now = Instant::now();
        if let (Some(shown), Some(at)) = (self.live.shown(), self.played_at) {
            shown.editor.advance(now.duration_since(at).as_secs_f64());
        }
        self.played_at = None;
    }

    /// Shows the screen and does what the user asks for. Returns what is to be drawn, and whether the window
    /// is to be closed.
    fn draw_ui(&mut self) -> (Drawing, bool) {
        let context = self.input.egui_ctx().clone();
        let facts = self.live.facts().clone();
        if let Some((size, pixels)) =
            self.live.shown().and_then(|shown| Some((shown.size, shown.take_pixels()?)))
        {
            self.picture = Some(self.canvas.take_picture(&self.gpu, size, &pixels));
        }
        let raw_input = self.take_input();
        let mut close = false;
        let output = ui::run_in_turns(&context, raw_input, |ui| {
            let stage = self.live.shown().zip(self.picture).map(|(shown, picture)| shown.stage(picture));
            let wishes = self.screen.show(ui, stage, &facts, self.note.as_ref());
            close |= self.grant(wishes);
        });
        self.input.handle_platform_output(&self.window, output.platform_output);
        let now = Instant::now();
        let delay =
            output.viewport_output.get(&egui::ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.next_draw =
            delay.and_then(|delay| now.checked_add(delay)).filter(|_| delay != Some(Duration::MAX));
        self.played_at = self.live.shown().filter(|shown| shown.editor.is_playing()).map(|_| now);
        let pixels_per_point = output.pixels_per_point;
        let primitives = context.tessellate(output.shapes, pixels_per_point);
        (Drawing { primitives, textures: output.textures_delta, pixels_per_point }, close)
    }

    /// What [`egui_winit::State::take_egui_input`] does, without asking the window for its size.
    fn take_input(&mut self) -> egui::RawInput {
        let pixels_per_point = egui_winit::pixels_per_point(self.input.egui_ctx(), &self.window);
        let size = egui::Vec2::new(self.size.width as f32, self.size.height as f32) / pixels_per_point;
        let input = self.input.egui_input_mut();
        input.time = Some(self.opened.elapsed().as_secs_f64());
        input.screen_rect =
            (size.x > 0.0 && size.y > 0.0).then(|| egui::Rect::from_min_size(egui::Pos2::ZERO, size));
        input.viewport_id = egui::ViewportId::ROOT;
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point =
            Some(self.window.scale_factor() as f32);
        input.take()
    }

    fn resized(&mut self, size: PhysicalSize<u32>) {
        self.size = size;
        self.window.request_redraw();
    }

    /// Does what the user asks for. Returns whether the window is to be closed.
    fn grant(&mut self, wishes: Wishes) -> bool {
        let mut close = wishes.close;
        let news = wishes.paste || wishes.reload || wishes.tell.is_some() || !wishes.save.is_empty();
        self.note = wishes.tell.or_else(|| self.note.take());
        if let (Some(shown), Some(size)) = (self.live.shown(), wishes.picture) {
            shown.fill(size);
        }
        for what in &wishes.save {
            let saved = self.live.save(*what, Path::new(""));
            // What could not be saved is not to be lost.
            close &= saved.is_ok();
            let said = saved.map(|path| path.map(|path| format!("saved {}", path.display())));
            let said = said.map_err(|error| error.to_string()).transpose();
            self.note = said.or_else(|| self.live.take_note()).or_else(|| self.note.take());
        }
        if wishes.reload {
            self.note = Some(self.reload());
        }
        if wishes.open {
            self.choose_file();
        }
        if wishes.paste {
            let text = self.input.clipboard_text().unwrap_or_default();
            self.input.egui_input_mut().events.push(egui::Event::Paste(text));
        }
        if news {
            self.window.request_redraw();
        }
        close
    }

    fn set_title(&mut self) {
        let facts = self.live.facts().clone();
        let title = self.screen.title(self.live.shown().map(|shown| &shown.editor), &facts);
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
    }
}

/// Wakes the window for news.
fn waking(window: &EventLoopProxy<Wake>) -> impl Fn() + Send + Sync + 'static {
    let window = window.clone();
    move || {
        // A loop that has ended needs no news.
        let _ = window.send_event(Wake::News);
    }
}

type Opened = (Gpu, Arc<Window>, wgpu::Instance, wgpu::Surface<'static>);

/// Opens a window and the GPU that is to draw in it.
fn open_window(event_loop: &ActiveEventLoop, cli: &Cli) -> Result<Opened> {
    let attributes = Window::default_attributes()
        .with_title("Relume player")
        .with_inner_size(LogicalSize::new(1200.0, 820.0))
        .with_min_inner_size(LogicalSize::new(320.0, 240.0))
        .with_visible(false);
    let window = Arc::new(event_loop.create_window(attributes).map_err(|e| no_display(&format!(" ({e})")))?);
    let display = Box::new(event_loop.owned_display_handle());
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle(display));
    let surface = instance
        .create_surface(window.clone())
        .map_err(|e| Error::Failed(format!("cannot draw in a window: {e}")))?;
    let gpu = Gpu::open_for(&instance, &surface, cli.adapter.as_deref())?;
    Ok((gpu, window, instance, surface))
}
