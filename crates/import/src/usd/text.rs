//! Checks a text of OpenUSD (`.usda`) before the library reads it.
//!
//! The library calls itself for brackets in brackets, and takes whatever stands between `<` and `>` for a path and any string for a name. What would make it
//! run out of stack, or go up a path for ever, is found here; what is wrong in other ways, it says itself.

use super::names::{braces_close, refused};
use logos::Logos;
use openusd::usda::token::Token;

/// Brackets in brackets.
const DEEPEST: usize = 500;

/// Looks through a whole text.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    // The library refuses all else, and stops at what is no token.
    let Ok(text) = std::str::from_utf8(bytes) else { return Ok(()) };
    let mut depth = 0_usize;
    let mut names = Names::default();
    for token in Token::lexer(text).map_while(Result::ok) {
        match token {
            Token::Punctuation('(' | '[' | '{') => depth += 1,
            Token::Punctuation(')' | ']' | '}') => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST {
            return Err(format!("brackets are more than {DEEPEST} deep"));
        }
        let named = names.next(&token, depth);
        match token {
            Token::PathRef(path) if !braces_close(path.as_bytes()) => return Err(refused(path)),
            Token::String(name) if named && name.contains(['{', '}']) => return Err(refused(name)),
            _ => {}
        }
    }
    Ok(())
}

/// Where strings are names of prims, or of variants and their sets.
#[derive(Default)]
struct Names {
    /// How deep the brackets were at a keyword that names follow, while its value has not ended.
    keyword: Option<usize>,
    /// The last token began or ended a block: strings that follow are what variants are called.
    block: bool,
}

impl Names {
    /// Whether this token is such a name, if it is a string.
    fn next(&mut self, token: &Token<'_>, depth: usize) -> bool {
        let block = std::mem::replace(&mut self.block, matches!(token, Token::Punctuation('{' | '}')));
        let within = self.keyword.is_some();
        match token {
            Token::Def
            | Token::Over
            | Token::Class
            | Token::VariantSet
            | Token::VariantSets
            | Token::Variants
            | Token::Identifier("defaultPrim") => self.keyword = Some(depth),
            // The value is this string, or a list or dictionary that ends here.
            Token::String(_) | Token::Punctuation(']' | '}') if self.keyword == Some(depth) => {
                self.keyword = None
            }
            _ => {}
        }
        within || block
    }
}
