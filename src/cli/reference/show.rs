//! What is kept, and whether it is of one image.

use std::io::{self, Write};

use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, Table};

use crate::cli::compare::usage;
use crate::cli::progress::{percent, time};
use crate::experiment::ScenePlan;
use crate::experiment::cache::{Kept, compare};
use crate::report::{Verdict, cut};

/// The scene, as far as references depend on it.
pub(super) fn title(out: &mut impl Write, scene: &ScenePlan) -> io::Result<()> {
    let length = scene.longest().map_or_else(|| "any length".to_owned(), |edges| format!("up to {edges} edges"));
    writeln!(out, "{}, {} × {}, paths of {length}", cut(&scene.name, 40), scene.film.width, scene.film.height)
}

/// A line for each method.
pub(super) fn list(out: &mut impl Write, kept: &[Kept]) -> io::Result<()> {
    if kept.is_empty() {
        return writeln!(out, "  no reference is kept; render one with --add 10m");
    }
    let mut table = Table::new();
    table.load_style(NOTHING).set_header(["  method", "spp", "time", "noise of a pixel"]);
    for kept in kept {
        let noise = kept.noise().map_or_else(|| "-".to_owned(), percent);
        let method = format!("  {}", cut(&kept.method, 40));
        table.add_row([method, kept.spp().to_string(), time(kept.info.render_seconds), noise]);
    }
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        column.set_cell_alignment(if index == 0 { CellAlignment::Left } else { CellAlignment::Right });
    }
    table.lines().try_for_each(|line| writeln!(out, "{}", line.trim_end()))
}

/// Tests each pair; whether one differs.
pub(super) fn check(out: &mut impl Write, kept: &[Kept]) -> anyhow::Result<bool> {
    let mut differs = false;
    for (i, a) in kept.iter().enumerate() {
        for b in &kept[i + 1..] {
            let names = format!("  {} and {}", cut(&a.method, 24), cut(&b.method, 24));
            let Some(test) = compare(a, b).map_err(usage)? else {
                writeln!(out, "{names}: too few samples to compare")?;
                continue;
            };
            writeln!(out, "{names}: {}", test.verdict)?;
            let percent = |share: f64| 100.0 * share;
            writeln!(
                out,
                "    image {:+.3} ± {:.3} %; finds {:.2} %, in a block {:.1} %; {} blocks, {} left out",
                percent(test.image.relative_difference),
                percent(test.image.relative_error),
                percent(test.image.detectable),
                percent(test.block_detectable),
                test.tested,
                test.left_out
            )?;
            if test.verdict != Verdict::Differ {
                continue;
            }
            differs = true;
            if let Some(worst) = test.worst.filter(|worst| worst.test.p_value < 1e-3) {
                let (x, y) = worst.block;
                let channel = ["red", "green", "blue"][worst.channel.min(2)];
                let difference = percent(worst.test.relative_difference);
                writeln!(
                    out,
                    "    most in {channel} of block ({x}, {y}): {difference:+.2} %, t = {:.1}",
                    worst.test.t
                )?;
            }
        }
    }
    if kept.len() < 2 {
        writeln!(out, "  nothing to compare: render another with --method path --add 10m")?;
    }
    Ok(differs)
}
