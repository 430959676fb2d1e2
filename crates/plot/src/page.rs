//! What all pages have in common: a head with their style, for light and for dark screens.

use crate::escape;

/// The style that every page has. Links and what can be opened show where the keyboard is.
const STYLE: &str = "html { color-scheme: light dark }
body { font: 15px/1.45 system-ui, sans-serif; color: light-dark(#222, #ddd); background: light-dark(#fff, #1b1b1b); max-width: 90rem; margin: 2rem auto; padding: 0 1rem }
p { max-width: 60rem; margin: .3rem 0 }
figure { display: inline-block; width: min(100%, 42rem); margin: .5rem 1rem .5rem 0; vertical-align: top }
figcaption { font-weight: 600 }
svg { width: 100%; font: 12px system-ui, sans-serif; fill: currentColor }
svg .grid { stroke: light-dark(#ddd, #444) }
svg polyline, svg g path { stroke-width: 2 }
svg .middle { text-anchor: middle }
svg .end { text-anchor: end }
.wide { overflow-x: auto }
table { border-collapse: collapse; margin: .5rem 0 }
th, td { padding: .15rem .6rem; border-bottom: 1px solid light-dark(#ddd, #444); text-align: right; white-space: nowrap }
th { vertical-align: bottom }
.text { text-align: left }
a { color: inherit }
:focus-visible { outline: 2px solid light-dark(#0072b2, #56b4e9); outline-offset: 2px }
";

/// The beginning of a page with a title that is also its headline; `style` is what it has of its own.
pub fn head(title: &str, style: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>\n{STYLE}{style}</style>\n<h1>{title}</h1>\n"
    )
}

/// The end of a page.
pub const FOOT: &str = "</html>\n";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_title_is_text_and_a_style_is_added() {
        let page = head("a < b", ".own { color: red }\n") + FOOT;
        assert_eq!(page.matches("a &lt; b").count(), 2);
        assert!(page.contains(".own { color: red }\n</style>") && page.ends_with("</html>\n"));
    }
}
