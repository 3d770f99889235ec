//! `evswarm replay`, `video` and `explain`: a recording or a run, looked at in a terminal or as a film.

use std::fs::File;
use std::io::{BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow, bail};
use api::explanation::Explanation;
use recording::{Reader, Samples};
use swarm::run::Run;

use super::client::{Client, Server};
use super::{Failure, output};
use crate::documents::{BuiltinArenas, parse, resolve};
use crate::recording::{Film, Moments, View, epoch_of, lines, step_of};

/// Robots of which a line is shown.
const LINES: usize = 8;
/// Pixels of a film along its longer side.
const PIXELS: u32 = 480;
/// Most pictures of a film.
const MOST_PICTURES: usize = 100_000;

#[derive(Debug, clap::Args)]
pub struct Source {
    /// A recording's file, or the id of a run of a service, whose recording is fetched.
    source: String,
    /// Name of the run's recording: what it recorded of itself, or the number of another.
    #[arg(long, default_value = "live")]
    recording: String,
    /// First step, counted over all phases [default: the first that is recorded].
    #[arg(long)]
    from_step: Option<u64>,
    /// Steps from there [default: all].
    #[arg(long)]
    steps: Option<u64>,
    /// Show every so many steps.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    #[command(flatten)]
    server: Server,
}

#[derive(Debug, clap::Args)]
pub struct ReplayArguments {
    #[command(flatten)]
    source: Source,
    /// Times as fast as the robots are; 0 waits for nothing.
    #[arg(long, default_value_t = 8.0)]
    speed: f64,
    /// Characters across.
    #[arg(long, default_value_t = 76)]
    width: usize,
}

#[derive(Debug, clap::Args)]
pub struct VideoArguments {
    #[command(flatten)]
    source: Source,
    /// The film: .gif needs nothing; .mp4 and .webm need ffmpeg.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Pictures a second.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=50))]
    rate: u32,
    /// Pixels along the longer side.
    #[arg(long, default_value_t = PIXELS, value_parser = clap::value_parser!(u32).range(64..=4_096))]
    pixels: u32,
}

/// A recording that is open, with the file that it was fetched to.
struct Open {
    reader: Reader<File>,
    _fetched: Option<tempfile::NamedTempFile>,
}

fn open(source: &Source) -> Result<Open, Failure> {
    let path = Path::new(&source.source);
    let (file, fetched) = if path.is_file() {
        let file = File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        (file, None)
    } else if source.source.chars().all(|c| c.is_ascii_hexdigit()) {
        let client = Client::new(&source.server);
        let mut fetched = tempfile::NamedTempFile::new().context("cannot make a file")?;
        let route = format!("/v1/runs/{}/recordings/{}", source.source, source.recording);
        client.save(&route, fetched.as_file_mut())?;
        let file = fetched.reopen().context("cannot read what was fetched")?;
        (file, Some(fetched))
    } else {
        return Err(anyhow!("{} is no file and no run's id", path.display()).into());
    };
    let reader = Reader::open(file)
        .with_context(|| format!("cannot read the recording {}", source.source))?;
    Ok(Open {
        reader,
        _fetched: fetched,
    })
}

/// Calls for each moment that is to be shown.
fn each_moment(
    source: &Source,
    open: &mut Open,
    mut show: impl FnMut(&Samples, usize, u64) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let header = open.reader.header().clone();
    let layout = *open.reader.layout();
    let start = header.from_epoch * u64::from(header.steps_per_epoch);
    let from = source.from_step.unwrap_or(start).max(start);
    let end = source
        .steps
        .map_or(u64::MAX, |steps| from.saturating_add(steps));
    let there = open.reader.samples();
    let mut block = Samples::default();
    let mut shown = false;
    for sample in Moments::new(&header, &layout, from, source.every) {
        if sample >= there.end || step_of(&header, layout.place(sample)) >= end {
            break;
        }
        let is_in =
            block.count > 0 && (block.first..block.first + block.count as u64).contains(&sample);
        if !is_in {
            block = open
                .reader
                .block(sample)
                .context("the recording ends here")?;
        }
        show(&block, (sample - block.first) as usize, sample)?;
        shown = true;
    }
    if shown {
        return Ok(());
    }
    let last = there.end.checked_sub(1).filter(|last| *last >= there.start);
    let end = last.map_or(start, |last| step_of(&header, layout.place(last)));
    Err(anyhow!("no moment is to be shown: the recording ends at step {end}").into())
}

pub fn replay(arguments: &ReplayArguments) -> Result<(), Failure> {
    let source = &arguments.source;
    let mut open = open(source)?;
    let header = open.reader.header().clone();
    let layout = *open.reader.layout();
    let arenas = [Some(&header.arena), header.training_arena.as_ref()];
    let views = arenas.map(|arena| arena.map(|arena| View::new(arena, arguments.width)));
    let is_terminal = std::io::stdout().is_terminal();
    let begun = Instant::now();
    let mut shown: u32 = 0;
    let pause_s = match arguments.speed > 0.0 {
        true => source.every as f64 * header.step_s / arguments.speed,
        false => 0.0,
    };
    if is_terminal {
        output::say_bytes(b"\x1b[2J")?;
    }
    each_moment(source, &mut open, |block, at, sample| {
        let place = layout.place(sample);
        let epoch = epoch_of(&header, place.arena_epoch);
        let view = views[usize::from(epoch.in_training)].as_ref();
        let view = view.or(views[0].as_ref());
        let title = format!(
            "step {}  epoch {} ({} {}{})  step {} of {}\n",
            step_of(&header, place),
            place.arena_epoch,
            epoch.phase,
            epoch.phase_epoch,
            if epoch.in_training {
                ", training arena"
            } else {
                ""
            },
            place.step,
            header.steps_per_epoch
        );
        let mut text = title;
        if let Some(view) = view {
            text += &view.show(&header, block, at);
        }
        text += &lines(&header, block, at, LINES);
        if is_terminal {
            // Home, each line cleared to its end.
            let text = text.replace('\n', "\x1b[K\n");
            output::say_bytes(format!("\x1b[H{text}\x1b[J").as_bytes())?;
            shown += 1;
            let due = Duration::from_secs_f64((pause_s * f64::from(shown)).min(1e9));
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
        } else {
            output::say_bytes(text.as_bytes())?;
        }
        Ok(())
    })
}

/// Where the pictures of a film go.
enum FilmFile {
    Gif(Box<gif::Encoder<BufWriter<File>>>),
    Ffmpeg(std::process::Child),
}

pub fn video(arguments: &VideoArguments) -> Result<(), Failure> {
    let source = &arguments.source;
    let mut open = open(source)?;
    let header = open.reader.header().clone();
    let layout = *open.reader.layout();
    let cannot = || anyhow!("the arena cannot be drawn at {} pixels", arguments.pixels);
    let film = Film::new(&header.arena, arguments.pixels).ok_or_else(cannot)?;
    let [width, height] = film.size();
    let mut out = None;
    let mut pictures = 0;
    let filmed = each_moment(source, &mut open, |block, at, sample| {
        let epoch = epoch_of(&header, layout.place(sample).arena_epoch);
        // A film is of one arena.
        if epoch.in_training && header.training_arena.is_some() {
            return Ok(());
        }
        pictures += 1;
        if pictures > MOST_PICTURES {
            return Err(anyhow!(
                "a film has at most {MOST_PICTURES} pictures: choose fewer --steps or a larger --every"
            )
            .into());
        }
        let out = match &mut out {
            Some(out) => out,
            // Nothing is written before there is something to be shown.
            None => out.insert(begin_film(&arguments.out, [width, height], arguments.rate)?),
        };
        let mut pixels = film.show(&header, block, at);
        add_picture(out, [width, height], arguments.rate, &mut pixels)?;
        Ok(())
    });
    let Some(out) = out else {
        filmed?;
        return Err(anyhow!("no moment of the target arena is there to be shown").into());
    };
    let ended = filmed.and_then(|()| Ok(end_film(out, &arguments.out)?));
    if ended.is_err() {
        crate::recording::remove(&arguments.out);
    }
    ended?;
    output::say(format_args!(
        "{}: {pictures} pictures",
        arguments.out.display()
    ))
}

fn begin_film(path: &Path, [width, height]: [u32; 2], rate: u32) -> anyhow::Result<FilmFile> {
    let end = path
        .extension()
        .and_then(|end| end.to_str())
        .unwrap_or_default();
    match end {
        "gif" => {
            let file =
                File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
            let (width, height) = (u16::try_from(width)?, u16::try_from(height)?);
            let mut encoder = gif::Encoder::new(BufWriter::new(file), width, height, &[])?;
            encoder.set_repeat(gif::Repeat::Infinite)?;
            Ok(FilmFile::Gif(Box::new(encoder)))
        }
        "mp4" | "webm" => {
            let codec = if end == "mp4" {
                "libx264"
            } else {
                "libvpx-vp9"
            };
            let size = format!("{width}x{height}");
            let rate = rate.to_string();
            let child = Command::new("ffmpeg")
                .args([
                    "-y",
                    "-loglevel",
                    "error",
                    "-f",
                    "rawvideo",
                    "-pix_fmt",
                    "rgba",
                ])
                .args(["-s", &size, "-r", &rate, "-i", "-", "-c:v", codec])
                .args(["-pix_fmt", "yuv420p"])
                .arg(path)
                .stdin(Stdio::piped())
                .spawn();
            child.map(FilmFile::Ffmpeg).map_err(|error| {
                anyhow!("a .{end} needs the program ffmpeg, which cannot be started ({error}); a .gif needs nothing")
            })
        }
        _ => bail!("{} ends in neither .gif, .mp4 nor .webm", path.display()),
    }
}

fn add_picture(
    film: &mut FilmFile,
    [width, height]: [u32; 2],
    rate: u32,
    pixels: &mut [u8],
) -> anyhow::Result<()> {
    match film {
        FilmFile::Gif(encoder) => {
            let (width, height) = (u16::try_from(width)?, u16::try_from(height)?);
            let mut frame = gif::Frame::from_rgba_speed(width, height, pixels, 30);
            // Hundredths of a second.
            frame.delay = (100 / rate).max(2) as u16;
            encoder.write_frame(&frame)?;
        }
        FilmFile::Ffmpeg(child) => {
            let input = child.stdin.as_mut().context("ffmpeg takes no pictures")?;
            input.write_all(pixels).context("ffmpeg has ended")?;
        }
    }
    Ok(())
}

fn end_film(film: FilmFile, path: &Path) -> anyhow::Result<()> {
    match film {
        FilmFile::Gif(encoder) => {
            let mut file = encoder.into_inner()?;
            file.flush()
                .with_context(|| format!("cannot write {}", path.display()))
        }
        FilmFile::Ffmpeg(mut child) => {
            drop(child.stdin.take());
            let status = child.wait().context("ffmpeg cannot be waited for")?;
            if status.success() {
                Ok(())
            } else {
                bail!("ffmpeg ended with {status}")
            }
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct ExplainArguments {
    /// A run spec's file, or the id of a run of a service.
    source: String,
    /// All figures, as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    server: Server,
}

/// Time between two questions to a service that is still stepping the run.
const ASK_EVERY: Duration = Duration::from_secs(1);

pub fn explain(arguments: &ExplainArguments) -> Result<(), Failure> {
    let path = Path::new(&arguments.source);
    let explanation = if path.is_file() {
        let text = super::run::read(path)?;
        let spec = parse(&text)
            .and_then(|value| resolve(&value, &BuiltinArenas))
            .map_err(Failure::WrongSpec)?;
        let run = Run::new(spec.run_spec()).map_err(super::run::wrong)?;
        crate::explain::explain(run, &|| false, &mut [])?
    } else {
        let client = Client::new(&arguments.server);
        let route = format!("/v1/runs/{}/explain", arguments.source);
        loop {
            let answer: serde_json::Value = client.get(&route)?;
            if answer.get("sentence").is_some() {
                break serde_json::from_value::<Explanation>(answer)
                    .context("the service explains otherwise than this program")?;
            }
            let (steps, done) = (&answer["robot_steps"], answer["progress"].as_f64());
            let share = 100.0 * done.unwrap_or(0.0);
            tracing::info!("stepping the run again, {steps} robot-steps: {share:.0} %");
            std::thread::sleep(ASK_EVERY);
        }
    };
    if arguments.json {
        let text = serde_json::to_string_pretty(&explanation).context("it is no JSON")?;
        return output::say(text);
    }
    output::say(&explanation.sentence)?;
    for behaviour in &explanation.behaviours {
        output::say(format_args!(
            "{:<13} {:5.1} % of the counted steps, in {} of {} epochs",
            behaviour.name,
            100.0 * behaviour.share,
            behaviour.epochs,
            explanation.epochs
        ))?;
    }
    output::say(format_args!(
        "{} robot-steps were simulated for this",
        explanation.simulated_robot_steps
    ))
}
