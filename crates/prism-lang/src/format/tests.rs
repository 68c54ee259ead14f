//! Layouts as expected; and for any layout of the input, the same tokens and comments, once and for all.

use super::*;
use crate::lexer::TokenKind;
use proptest::prelude::*;

fn model(text: &str) -> String {
    format_model(text).unwrap_or_else(|mistakes| panic!("{text}\n{mistakes:?}"))
}

#[test]
fn items_stand_on_lines_of_their_own_and_comments_stay_with_them() {
    let text = "// A robot.\n\n\n\n//  Two lines.\nmdp const int N=3 ; // of them\n
const double p; formula busy=x>0&(x<N|x= -1 + 2*3);
module robot   x:[-1..N] init 0;// where

  // Goes on.
  [go]!busy&x<N->p:(x'=x+1)&(y'=-x)+1-p:true;
  [] x=N -> true ;

  // Nothing else.
endmodule
module other=robot[x=z,y=w]endmodule
label\"done\"=x=N;
rewards\"time\"[go]true:2*(x+1);x=0:x>1?1:0.5;endrewards
init x>=-1 endinit
// The end.";
    let formatted = "// A robot.

//  Two lines.
mdp
const int N = 3; // of them

const double p;
formula busy = x>0 & (x<N | x = -1 + 2*3);

module robot
  x : [-1..N] init 0; // where

  // Goes on.
  [go] !busy & x<N -> p : (x'=x+1) & (y'=-x) + 1-p : true;
  [] x=N -> true;

  // Nothing else.
endmodule

module other = robot [x=z, y=w] endmodule
label \"done\" = x=N;

rewards \"time\"
  [go] true : 2*(x+1);
  x=0 : x>1 ? 1 : 0.5;
endrewards

init x>=-1 endinit
// The end.
";
    assert_eq!(model(text), formatted);
    assert_eq!(model(formatted), formatted);
}

#[test]
fn what_is_too_wide_is_broken_where_it_holds_together_least() {
    let text = "dtmc module m x:[0..9];
[] x=0 & (first_condition_of_all | second_condition_of_all) & third_condition_of_all -> 0.5:(x'=1)+0.25:(x'=2)+0.25:true;
[] x=1 -> // comes first
0.5 : (x'=2)   // half of it
// the other half
+ 0.5 : (x'=3); endmodule
formula long = first_condition_of_all & (second_condition_of_all | third_condition_of_all) & fourth_condition_of_all;";
    let formatted = "dtmc

module m
  x : [0..9];
  [] x=0 & (first_condition_of_all | second_condition_of_all) & third_condition_of_all ->
    0.5 : (x'=1)
    + 0.25 : (x'=2)
    + 0.25 : true;
  [] x=1 -> // comes first
    0.5 : (x'=2)   // half of it
    // the other half
    + 0.5 : (x'=3);
endmodule

formula long =
  first_condition_of_all
    & (second_condition_of_all | third_condition_of_all)
    & fourth_condition_of_all;
";
    assert_eq!(model(text), formatted);
    assert_eq!(model(formatted), formatted);
}

#[test]
fn properties_keep_their_operators_in_one_piece() {
    let text = "const int T=5;\n// Safe.\n\"safe\":P>=0.99[G<=T !\"bad\"];R{\"time\"}max=?[C<=T] ; P=?[F[1,T]x=1&y>-1];
filter(min,P=?[(x=1)U\"done\"],\"init\"); P=? [ F x=1  ||  G y=0 ]; <<1,2>> P>=1 [ X x=1 ]; S=?[x=1]/R=?[S]";
    let formatted = "const int T = 5;
// Safe.
\"safe\": P>=0.99 [ G<=T !\"bad\" ];
R{\"time\"}max=? [ C<=T ];
P=? [ F[1,T] x=1 & y>-1 ];
filter(min, P=? [ (x=1) U \"done\" ], \"init\");
P=? [ F x=1 || G y=0 ];
<<1,2>> P>=1 [ X x=1 ];
S=? [ x=1 ]/R=? [ S ]
";
    assert_eq!(format_properties(text).unwrap(), formatted);
    assert_eq!(format_properties(formatted).unwrap(), formatted);
}

#[test]
fn compositions_keep_their_symbols() {
    let text = "mdp module a x:bool; [s]true->true; endmodule module b=a[x=y]endmodule
system   a|[s]|b   / {s}   endsystem";
    let formatted = model(text);
    assert!(
        formatted.ends_with("\nsystem a|[s]|b / {s} endsystem\n"),
        "{formatted}"
    );
    assert_eq!(model(&formatted), formatted);
}

#[test]
fn a_text_with_mistakes_is_not_formatted() {
    let mistakes = format_model("dtmc modul m endmodule").unwrap_err();
    assert_eq!(
        mistakes[0].remedy.as_deref(),
        Some("Did you mean `module`?")
    );
    assert_eq!(format_model("").unwrap(), "");
    assert_eq!(
        format_model("\r\n // only this\r\n").unwrap(),
        "// only this\n"
    );
}

/// Tokens of a model with everything that a layout can break.
const PIECES: &str = "mdp const int N = 3 ; const double p = 1 - 0.5 ; global g : [ 0 .. N ] init - 1 + 1 ;
formula busy = x > 0 & ! ( x = N ) | x < - 1 ; module a x : [ - 1 .. N ] ; c : bool init false ;
[ go ] busy & x < N => c -> p : ( x' = x + 1 ) & ( c' = ! c ) + 1 - p : true ; [ ] x = min ( N , 2 ) -> true ;
endmodule module b = a [ x = y , c = d ] endmodule label \"done\" = x = N ? c : d ;
rewards \"time\" [ go ] true : 2 * ( x + 1 ) / 3 ; x = 0 : pow ( 2 , x ) ; endrewards init x >= - 1 endinit";

fn comments(text: &str) -> Vec<&str> {
    text.lines()
        .filter_map(|line| line.find("//").map(|at| line[at..].trim_end()))
        .collect()
}

fn tokens(text: &str) -> Vec<(TokenKind, &str)> {
    let (tokens, mistakes) = tokenize(text);
    assert!(mistakes.is_empty(), "{mistakes:?}");
    tokens
        .iter()
        .map(|token| (token.kind, token.text))
        .collect()
}

proptest! {
    #[test]
    fn any_layout_keeps_its_tokens_and_comments_and_is_formatted_once(
        blanks in prop::collection::vec(
            prop::sample::select(vec![" ", " ", " ", " ", " ", "\n", "\n\n\n", "\t", " // one\n", "\n\n// two\n \n", " //\n//x\n"]),
            400,
        )
    ) {
        let pieces: Vec<&str> = PIECES.split_whitespace().collect();
        prop_assert!(pieces.len() <= blanks.len());
        let text: String = pieces.iter().zip(&blanks).flat_map(|(piece, blank)| [*piece, *blank]).collect();
        let formatted = model(&text);
        prop_assert_eq!(tokens(&formatted), tokens(&text));
        prop_assert_eq!(comments(&formatted), comments(&text));
        prop_assert!(!formatted.lines().any(|line| line.ends_with(' ')), "{}", formatted);
        prop_assert_eq!(model(&formatted), formatted);
    }
}
