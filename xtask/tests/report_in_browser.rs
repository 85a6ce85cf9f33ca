//! The report in a real browser, where one is there: in light and dark, as wide as a desk and as narrow as a phone.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Widths of windows, in pixels.
const WIDTHS: [u32; 2] = [1280, 390];

/// Names and, in that theme, the colours of the page and of the first series, as `style.css` has them.
const THEMES: [(&str, [u8; 3], [u8; 3]); 2] =
    [("light", [0xff, 0xff, 0xff], [0x02, 0x3d, 0x79]), ("dark", [0x15, 0x17, 0x1c], [0x0f, 0x67, 0xbb])];

fn browser() -> Option<&'static str> {
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success());
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find(is_there)
}

/// What the browser prints.
fn browse(browser: &str, profile: &Path, page: &Path, theme: usize, width: u32, options: &[&str]) -> String {
    let output = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"])
        .arg(format!("--user-data-dir={}", profile.display()))
        // 0 is dark and 1 is light.
        .arg(format!("--blink-settings=preferredColorScheme={}", 1 - theme))
        .arg(format!("--window-size={width},1600"))
        .args(options)
        .arg(format!("file://{}", page.display()))
        .output()
        .expect("the browser starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn pixels(path: &Path) -> (u32, Vec<[u8; 3]>) {
    let file = std::fs::File::open(path).expect("a screenshot");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let frame = reader.next_frame(&mut bytes).expect("PNG");
    let channels = frame.color_type.samples();
    (frame.width, bytes.chunks_exact(channels).map(|p| [p[0], p[1], p[2]]).collect())
}

/// Tells the page whose frame this is in how wide it is, and what is wrong with it.
const MEASURING: &str = "<script>onload = () => {
  const faults = [], of = element => element.getBoundingClientRect();
  for (const svg of document.querySelectorAll('.chart svg')) {
    const frame = of(svg), scale = frame.width / svg.viewBox.baseVal.width, texts = [...svg.querySelectorAll('text')];
    texts.forEach((text, i) => {
      const a = of(text), name = text.textContent;
      if (scale * parseFloat(getComputedStyle(text).fontSize) < 10) faults.push('too small to read: ' + name);
      if (a.left < frame.left || a.right > frame.right || a.top < frame.top || a.bottom > frame.bottom)
        faults.push('beyond the chart: ' + name);
      for (const other of texts.slice(0, i)) {
        const b = of(other), across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        if (across > 0.5 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 3)
          faults.push('one on the other: ' + name + ', ' + other.textContent);
      }
    });
  }
  for (const code of document.querySelectorAll('tr.command code')) {
    const frame = of(code.closest('.scroll')), part = of(code);
    if (part.left < frame.left - 1 || part.right > frame.right + 1) { faults.push('a command is cut off'); break; }
  }
  parent.postMessage(document.documentElement.scrollWidth + ' ' + faults.join('; '), '*');
}</script></body>";

/// Both themes are obeyed, charts are drawn and their words read, nothing is wider than the window, and paper takes it.
#[test]
fn the_report_looks_as_it_should() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no browser is there");
        return;
    };
    let folder = tempfile::tempdir().expect("a directory for the test");
    let here: PathBuf = folder.path().canonicalize().expect("a path");
    let sweep = "sweep builtin:terrain:2k --quick --rounds 1 --rays 256 --judged-rays 32 --out out";
    let output = Command::new(env!("CARGO_BIN_EXE_xtask")).args(sweep.split(' ')).current_dir(&here).output();
    assert!(output.expect("xtask starts").status.success());
    let page = here.join("out/report.html");
    // A copy that measures itself, in a frame of another page: windows have a least width, and frames do not.
    let text = std::fs::read_to_string(&page).expect("the report");
    std::fs::write(here.join("measuring.html"), text.replace("</body>", MEASURING)).expect("written");
    for (theme, (name, paper, first_series)) in THEMES.into_iter().enumerate() {
        for width in WIDTHS {
            let picture = here.join("page.png");
            let screenshot = format!("--screenshot={}", picture.display());
            browse(browser, &here.join("profile"), &page, theme, width, &[&screenshot]);
            let (found, pixels) = pixels(&picture);
            assert_eq!(found, width);
            let part = |colour: [u8; 3]| pixels.iter().filter(|p| **p == colour).count() as f64 / pixels.len() as f64;
            assert!((0.3..0.98).contains(&part(paper)), "{name}, {width}: {} of the page is paper", part(paper));
            assert!(part(first_series) > 1e-5, "{name}, {width}: no series is drawn");
            let frame = here.join("frame.html");
            let html = format!(
                "<script>onmessage = message => document.title = 'measured ' + message.data</script>\
                 <iframe width={width} height=800 style=\"border: 0\" src=\"measuring.html\"></iframe>"
            );
            std::fs::write(&frame, html).expect("written");
            let options = ["--dump-dom", "--virtual-time-budget=5000"];
            let dom = browse(browser, &here.join("profile"), &frame, theme, 1600, &options);
            let title = dom.split("<title>measured ").nth(1).and_then(|rest| rest.split("</title>").next());
            let (found, faults) = title.and_then(|text| text.split_once(' ')).expect("what was measured");
            let found: u32 = found.parse().expect("a number");
            assert!((width - 30..=width).contains(&found), "{name}: the page is {found} wide in a frame of {width}");
            assert_eq!(faults, "", "{name}, in a frame of {width}");
        }
    }
    let pdf = here.join("page.pdf");
    let print = format!("--print-to-pdf={}", pdf.display());
    browse(browser, &here.join("profile"), &page, 0, WIDTHS[0], &[&print]);
    assert!(std::fs::read(pdf).expect("a document").starts_with(b"%PDF"));
}
