//! The summary for a terminal: verdict first, then the matrix, the main
//! conflicts, and where to look.
//!
//! Text of the study is stripped of control characters before it is printed,
//! so that no file can write escape sequences to the reader's terminal.

use evidence::{
    Conclusion, CopyKind, DescriptionGap, Evidence, LineageQuestion, Measure, Outcome, Requirement,
    StudyResult, Technique,
};
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

use crate::number;
use crate::plan;
use crate::view::{View, left_out_of_all, merged, unbroken};
use crate::words::{self, Mark};

/// Narrower than this nothing can be laid out.
const LEAST_WIDTH: usize = 40;
/// Columns of an identifier that are shown.
const LONGEST_ID: usize = 12;
/// Suspects listed; the rest are counted.
const SUSPECTS_SHOWN: usize = 8;
/// Pairs of two numbers that are not comparable that are listed; the rest are counted.
const INCOMPARABLE_SHOWN: usize = 5;
/// Undecided pairs listed with what would decide them; the rest are counted.
const PLANS_SHOWN: usize = 6;

/// The summary.
pub fn render(study: &StudyResult, width: usize, colour: bool) -> String {
    let mut page = Page {
        width: width.max(LEAST_WIDTH),
        colour,
        text: String::new(),
    };
    let view = View { study };
    page.heading(&study.title);
    verdicts(&mut page, study);
    matrix(&mut page, view);
    combined(&mut page, study);
    outcomes(&mut page, view);
    further(&mut page, view);
    suspects(&mut page, study);
    gaps(&mut page, view);
    description_gaps(&mut page, study);
    page.text
}

struct Page {
    width: usize,
    colour: bool,
    text: String,
}

impl Page {
    fn line(&mut self, text: &str) {
        self.text.push_str(text.trim_end());
        self.text.push('\n');
    }

    fn heading(&mut self, text: &str) {
        if !self.text.is_empty() {
            self.line("");
        }
        for line in wrap(text, self.width) {
            let styled = self.styled(&line, "1");
            self.line(&styled);
        }
    }

    /// Wrapped text, its first line after `label`, the rest below its start.
    fn item(&mut self, label: &str, style: &str, text: &str) {
        let indent = label.width();
        let lines = wrap(&unbroken(text), self.width.saturating_sub(indent).max(16));
        for (i, line) in lines.iter().enumerate() {
            let start = if i == 0 {
                self.styled(label, style)
            } else {
                " ".repeat(indent)
            };
            self.line(&format!("{start}{line}"));
        }
    }

    fn styled(&self, text: &str, style: &str) -> String {
        if self.colour && !style.is_empty() {
            format!("\x1b[{style}m{text}\x1b[0m")
        } else {
            text.to_owned()
        }
    }
}

/// The ANSI style of a tone: never the only sign, always beside a symbol.
fn style(mark: &Mark) -> &'static str {
    match mark.tone {
        "good" => "36",
        "bad" => "31;1",
        "open" => "33",
        "plain" => "",
        _ => "2",
    }
}

/// Words of the text in lines of at most `width` columns; a word that is
/// longer is broken. Control characters become spaces.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    let clean = clean(text);
    for word in clean.split(' ').filter(|word| !word.is_empty()) {
        for piece in pieces(word, width) {
            let line = lines.last_mut().map_or(0, |l| l.width());
            if line > 0 && line + 1 + piece.width() > width {
                lines.push(String::new());
            }
            if let Some(last) = lines.last_mut() {
                if !last.is_empty() {
                    last.push(' ');
                }
                last.push_str(&piece);
            }
        }
    }
    lines
}

/// Without control characters; a no-break space stays inside its word.
fn clean(text: &str) -> String {
    diagnostic::printable_line(text).into_owned()
}

fn pieces(word: &str, width: usize) -> Vec<String> {
    let mut pieces = vec![String::new()];
    let mut used = 0;
    for c in word.chars() {
        let wide = c.width().unwrap_or(0);
        if used + wide > width {
            pieces.push(String::new());
            used = 0;
        }
        used += wide;
        if let Some(last) = pieces.last_mut() {
            last.push(c);
        }
    }
    pieces
}

fn verdicts(page: &mut Page, study: &StudyResult) {
    if study.conclusions.is_empty() {
        page.item(
            "",
            "",
            "This study draws no conclusion yet: no requirement has evidence.",
        );
        return;
    }
    let common = left_out_of_all(study);
    for conclusion in &study.conclusions {
        let mark = words::concluded(conclusion);
        let label = format!(
            "{} {} ",
            mark.symbol,
            pad(&clean(&conclusion.requirement), id_width(study))
        );
        let sentence = format!("{}. {}", capital(&mark.word), conclusion.statement);
        page.item(&label, style(&mark), &sentence);
        let indent = " ".repeat(label.width());
        let conditions = conclusion.conditions();
        let conditions: Vec<String> = conditions
            .iter()
            .map(|(id, it)| format!("{id}: {it}"))
            .collect();
        if !conditions.is_empty() {
            let words = format!("Over which runs: {}.", conditions.join("; "));
            page.item(&indent, "", &words);
        }
        for looking in conclusion.looking.iter().filter(|it| it.look > 1) {
            page.item(&indent, "", &looking.statement);
        }
        for words in conclusion.left_out().filter(|it| !common.contains(it)) {
            page.item(&indent, "2", &format!("Left out: {words}"));
        }
        for sensitivity in &conclusion.clustering {
            page.item(&indent, "", &sensitivity.statement);
        }
    }
    for words in common {
        page.item("", "2", &format!("Left out of every verdict: {words}"));
    }
    if let Some(words) = words::error_rates(study) {
        page.item("", "2", &words);
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(chars).collect()
    })
}

/// Columns for the requirements' identifiers: as many as the longest has, within reason.
fn id_width(study: &StudyResult) -> usize {
    let ids = study.requirements.iter().map(|it| clean(&it.id).width());
    ids.max().unwrap_or(0).clamp(3, LONGEST_ID)
}

/// Padded on the right, or cut, to the width.
fn pad(text: &str, width: usize) -> String {
    let mut kept = String::new();
    for c in text.chars() {
        if kept.width() + c.width().unwrap_or(0) > width {
            break;
        }
        kept.push(c);
    }
    let missing = width - kept.width();
    kept + &" ".repeat(missing)
}

fn matrix(page: &mut Page, view: View) {
    if view.study.requirements.is_empty() {
        return;
    }
    page.heading("Requirements by techniques");
    let techniques = words::techniques(view.study);
    let ids = id_width(view.study) + 2;
    let column = page.width.saturating_sub(ids) / techniques.len();
    let heads: String = techniques
        .iter()
        .map(|t| pad(words::technique(*t), column))
        .collect();
    let heads = format!("{}{}", " ".repeat(ids), heads.trim_end());
    let styled = page.styled(&heads, "2");
    page.line(&styled);
    for requirement in &view.study.requirements {
        let current: Vec<Vec<&Evidence>> = techniques
            .iter()
            .map(|t| view.current(requirement, *t))
            .collect();
        // Trials of several batches stand below each other.
        let lines = current.iter().map(Vec::len).max().unwrap_or(0).max(1);
        for line in 0..lines {
            let pieces = techniques.iter().zip(&current);
            let cells: String = pieces
                .map(|(technique, pieces)| match (pieces.get(line), line) {
                    (None, 1..) => pad("", column),
                    (piece, _) => cell(
                        page,
                        view,
                        (requirement, *technique),
                        piece.copied(),
                        column,
                    ),
                })
                .collect();
            let id = if line == 0 {
                clean(&requirement.id)
            } else {
                String::new()
            };
            page.line(&format!("{}{cells}", pad(&id, ids)));
        }
    }
    let words = format!(
        "Intervals are {}, of computed values credible; the marks are those of the one-sided limits above{}.",
        words::intervals(view.study),
        words::at_looks(view.study)
    );
    page.item("", "2", &words);
}

fn cell(
    page: &Page,
    view: View,
    (requirement, technique): (&Requirement, Technique),
    piece: Option<&Evidence>,
    column: usize,
) -> String {
    let subject = view.quantity(requirement);
    let Some((evidence, finding)) = piece.and_then(|e| Some((e, e.finding(&subject)?))) else {
        return pad(words::not_shown(view.study, &subject, technique), column);
    };
    let mark = view.mark(requirement, &evidence.id, &finding.measure);
    let text = format!(
        "{} {}",
        mark.symbol,
        figures(&finding.measure, &mark, column)
    );
    page.styled(&pad(&text, column), style(&mark))
}

/// As much of the finding as fits the column.
fn figures(measure: &Measure, mark: &Mark, column: usize) -> String {
    let room = column.saturating_sub(3);
    let options = match measure {
        Measure::Counts {
            count,
            trials,
            interval,
            ..
        } if *trials > 0 => {
            let rate = number::percent(*count as f64 / *trials as f64);
            let counts = format!("{}/{}", number::count(*count), number::count(*trials));
            let interval = number::interval(*interval);
            vec![
                format!("{rate} [{interval}] {counts}"),
                format!("{rate} {counts}"),
                rate,
            ]
        }
        Measure::Probability {
            answer, credible, ..
        } => {
            let value = number::answer(answer);
            let wide = credible
                .as_ref()
                .filter(|c| c.interval.low < c.interval.high)
                .map(|c| format!("{value} [{}]", number::interval(c.interval)));
            wide.into_iter().chain([value]).collect()
        }
        _ => vec![mark.word.clone()],
    };
    let fitting = options.iter().find(|text| text.width() <= room);
    fitting.or(options.last()).cloned().unwrap_or_default()
}

/// What the independent evidence supports together, where there is anything to say.
fn combined(page: &mut Page, study: &StudyResult) {
    let said: Vec<_> = study
        .synthesis
        .combined
        .iter()
        .filter(|one| one.common.is_some())
        .collect();
    if said.is_empty() {
        return;
    }
    page.heading("Independent evidence pooled");
    for one in said {
        let label = format!("{}  ", pad(&clean(&one.requirement), id_width(study)));
        page.item(&label, "2", &one.statement);
    }
}

/// Further trials that would decide.
fn further(page: &mut Page, view: View) {
    let synthesis = &view.study.synthesis;
    let current: Vec<_> = synthesis.undecided.iter().filter(|u| u.current).collect();
    let not_planned = &synthesis.not_planned;
    if current.is_empty() && synthesis.deciding.is_empty() && not_planned.is_empty() {
        return;
    }
    page.heading("What would decide");
    page.item("", "", &plan::pricing(&synthesis.costs));
    if let Some(fixed) = plan::of_fixed_sizes(view.study) {
        page.item("", "", fixed);
    }
    if let Some(programme) = &synthesis.programme {
        page.item("= ", "33", &plan::programme(programme, &synthesis.costs));
    }
    let mut told = None;
    for one in &synthesis.deciding {
        // The cheapest of each requirement; the report has the others.
        if told.replace(&one.requirement) != Some(&one.requirement) {
            let words = plan::deciding(one, &synthesis.costs);
            let text = format!("requirement {}: {words}", one.requirement);
            page.item("+ ", "33", &text);
        }
    }
    for one in not_planned {
        let text = format!("requirement {}: {}", one.requirement, one.reason);
        page.item("– ", "", &text);
    }
    for one in current.iter().take(PLANS_SHOWN) {
        let words = match one.plans.first() {
            Some(first) => plan::plan(first, &synthesis.costs),
            None => "no plan of further trials was found".to_owned(),
        };
        let title = view.short_title(&one.subject);
        let text = format!("{} and {} on {title}: {words}", one.left, one.right);
        page.item("+ ", "33", &text);
    }
    let rest = current.len().saturating_sub(PLANS_SHOWN);
    if rest > 0 {
        page.item("  ", "", &format!("and {rest} more in the report"));
    }
}

fn outcomes(page: &mut Page, view: View) {
    let study = view.study;
    if study.comparisons.is_empty() {
        return;
    }
    page.heading("Comparisons");
    let counts: Vec<String> = words::OUTCOMES
        .iter()
        .map(|outcome| {
            let pairs = study.comparisons.iter().filter(|c| c.outcome == *outcome);
            let mark = words::outcome(*outcome);
            format!(
                "{}\u{a0}{}\u{a0}{}",
                mark.symbol,
                pairs.count(),
                mark.word.replace(' ', "\u{a0}")
            )
        })
        .collect();
    page.item("", "", &counts.join(", "));
    for pair in study.differences_of_one() {
        let title = view.short_title(&pair.subject);
        let words = format!(
            "{} and {} on {title}: {}",
            pair.left, pair.right, pair.reason
        );
        page.item("≠ of one alone: ", "", &words);
    }
    for pair in study.open_conflicts() {
        if pair.is_with_the_impossible() {
            let title = view.short_title(&pair.subject);
            page.item("≠ ", "31", &format!("On {title}: {}", pair.reason));
        }
    }
    let fits = study
        .comparisons
        .iter()
        .filter(|c| c.outcome == Outcome::Corroborates && !c.independent && !c.possibly_copied)
        .count();
    if fits > 0 {
        let words = "of those that agree are not independent: one side was tuned to the other, or both share data or draws.";
        page.item("", "", &format!("{fits} {words}"));
    }
    let copies = study.comparisons.iter();
    let copies = copies.filter(|c| c.outcome == Outcome::Corroborates && c.possibly_copied);
    let copies = copies.count();
    if copies > 0 {
        let words = "of those that corroborate are possibly copied, not corroboration.";
        page.item("", "", &format!("{copies} {words}"));
    }
    agreement(page, &study.conclusions);
    not_comparable(page, view);
    triggers(page, view);
    questions(page, study);
}

/// Why numbers are not comparable, for each pair that has two; how many have one or none.
fn not_comparable(page: &mut Page, view: View) {
    let pairs = view.study.comparisons.iter();
    let pairs = pairs.filter(|pair| pair.outcome == Outcome::NotComparable);
    let (two, fewer): (Vec<_>, Vec<_>) = pairs.partition(|pair| {
        [&pair.left, &pair.right].iter().all(|id| {
            let evidence = view.study.evidence.iter().find(|it| it.id == **id);
            let finding = evidence.and_then(|it| it.finding(&pair.subject));
            finding.is_some_and(|it| it.measure.estimate().is_some())
        })
    });
    for pair in two.iter().take(INCOMPARABLE_SHOWN) {
        let title = view.short_title(&pair.subject);
        let words = format!(
            "{} and {} on {title}: {}",
            pair.left, pair.right, pair.reason
        );
        page.item("– ", "", &words);
    }
    let rest = two.len().saturating_sub(INCOMPARABLE_SHOWN);
    if rest > 0 {
        page.item("  ", "", &format!("and {rest} more in the report"));
    }
    if !fewer.is_empty() && !two.is_empty() {
        let words = "not comparable because one side has no number; the matrix says why.";
        page.item("", "", &format!("{} {words}", fewer.len()));
    }
}

/// How often current evidence triggers a subject, where that is not shown to be alike.
fn triggers(page: &mut Page, view: View) {
    let conclusions = &view.study.conclusions;
    let is_current = |id: &String| conclusions.iter().any(|it| it.rests_on.contains(id));
    for pair in &view.study.comparisons {
        let Some(trigger) = &pair.trigger else {
            continue;
        };
        let alike = trigger.outcome == Outcome::Corroborates;
        if !alike && is_current(&pair.left) && is_current(&pair.right) {
            let title = view.short_title(&pair.subject);
            page.item("  ", "", &format!("Trigger of {title}: {}", trigger.reason));
        }
    }
}

/// What looks copied, and what settles it.
fn questions(page: &mut Page, study: &StudyResult) {
    let pieces = study.evidence.iter();
    let all = pieces.flat_map(|piece| &piece.lineage_questions);
    let open: Vec<_> = all.filter(|question| question.is_open()).collect();
    let is_of_itself = |question: &&LineageQuestion| match question.kind {
        CopyKind::Trials | CopyKind::Recordings => true,
        CopyKind::Constant
        | CopyKind::Counts
        | CopyKind::File
        | CopyKind::Rows
        | CopyKind::Product
        | CopyKind::Answer
        | CopyKind::Seeds => false,
    };
    let (trials, copied): (Vec<_>, Vec<_>) = open.into_iter().partition(is_of_itself);
    asked(page, "Possibly copied: state the lineage", &copied);
    asked(page, "Trials that are possibly not independent", &trials);
}

fn asked(page: &mut Page, heading: &str, open: &[&LineageQuestion]) {
    if !open.is_empty() {
        page.heading(heading);
    }
    for question in open {
        let places = question.places.join(", ");
        let places = if places.is_empty() {
            places
        } else {
            format!(" ({places})")
        };
        let text = format!("{}{places}: {}", question.finding, question.remedy);
        page.item("? ", "33", &text);
    }
}

fn agreement(page: &mut Page, conclusions: &[Conclusion]) {
    let independent = merged(conclusions, |c| &c.independent_agreement);
    let fitted = merged(conclusions, |c| &c.fitted_agreement);
    let labelled = [("+ ", "Independent", independent), ("~ ", "A fit", fitted)];
    for (label, kind, lines) in labelled {
        for (line, ids) in lines {
            page.item(label, "", &format!("{kind}, {}: {line}", ids.join(" and ")));
        }
    }
}

fn suspects(page: &mut Page, study: &StudyResult) {
    let suspects = study.suspected();
    if !suspects.is_empty() {
        page.heading("Suspects: where the evidence disagrees, and why");
    }
    for suspect in suspects.iter().take(SUSPECTS_SHOWN) {
        let state = match suspect.resolution() {
            Some((before, id, behind)) => format!("{before}{id}{behind}"),
            None => "still open".to_owned(),
        };
        let kind = words::inaccuracy(suspect.inaccuracy);
        let (rank, title, score) = (suspect.rank, &suspect.title, suspect.score);
        let line = format!("{rank}. {title} ({kind}, score {score:.1}, {state})");
        page.item("≠ ", "31;1", &line);
    }
    let rest = suspects.len().saturating_sub(SUSPECTS_SHOWN);
    if rest > 0 {
        page.item("  ", "", &format!("and {rest} more in the report"));
    }
    let missed = study.published.iter().filter(|f| !f.agrees).count();
    if missed > 0 {
        page.heading("Not as published");
        let of = study.published.len();
        page.item(
            "≠ ",
            "",
            &format!("{missed} of {of} figures, see the report"),
        );
    }
}

fn gaps(page: &mut Page, view: View) {
    let nowhere: Vec<_> = view
        .study
        .gaps
        .iter()
        .filter(|gap| gap.evidence.is_empty())
        .collect();
    if nowhere.is_empty() {
        return;
    }
    page.heading("Not covered by any evidence");
    for gap in nowhere {
        let title = view.title(&gap.subject);
        page.item("○ ", "2", &format!("{title}: {}", gap.reason));
    }
}

/// How much of robots' descriptions was not simulated, where that can move a number.
fn description_gaps(page: &mut Page, study: &StudyResult) {
    let pieces = study.evidence.iter();
    let with: Vec<_> = pieces
        .filter(|piece| {
            piece
                .description_gaps
                .iter()
                .any(DescriptionGap::can_matter)
        })
        .collect();
    if with.is_empty() {
        return;
    }
    page.heading("Not simulated as described");
    for piece in with {
        let counts = DescriptionGap::in_short(&piece.description_gaps);
        page.item(
            "△ ",
            "2",
            &format!("{}: {counts}; see the report", piece.id),
        );
    }
}
