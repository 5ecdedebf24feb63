//! Truth of tests and results of effects: NULL, quantifiers, sets, numbers.

use crate::domain::text;
use crate::run::symbolic;

/// Says whether the tests hold where `CUP.at` is TABLE, `TABLE.near` is SHELF, `BOX.users` is [H], and nothing else is set
/// but weights: CUP 2, BOX 1, PEN 2.
fn holds(tests: &str) -> bool {
    after("", tests)
}

/// Says whether the tests hold after the effects.
fn after(effects: &str, tests: &str) -> bool {
    let tasks = format!(
        "action Change(Agent A) {{ effects {{ {effects} }} }}
         action Test(Agent A) {{ preconditions {{ {tests} }} }}
         method Go(Agent A) {{ {{ subtasks {{ 1: Change(A); 2: Test(A) > 1; }}; }} }}"
    );
    symbolic(&text(&tasks), "Go(R)").outcome.found.is_some()
}

/// A step through NULL makes a comparison false, `!=` true.
#[test]
fn a_path_through_null_has_no_value() {
    // R.holds is NULL, so R.holds.at and R.holds.weight are paths through NULL.
    assert!(!holds("R.holds.at == TABLE;"));
    assert!(!holds("R.holds.at == NULL;"));
    assert!(!holds("R.holds.at == R.holds.at;"));
    assert!(holds("R.holds.at != TABLE;"));
    assert!(holds("R.holds.at != NULL;"));
    assert!(holds("R.holds.at != R.holds.at;"));
    for op in ["<", "<=", ">", ">="] {
        assert!(!holds(&format!("R.holds.weight {op} 1;")), "{op}");
        assert!(!holds(&format!("1 {op} R.holds.weight;")), "{op}");
    }
    assert!(!holds("H >> R.holds.users;"));
    // Not a member, as for `!=`.
    assert!(holds("H !>> R.holds.users;"));
    assert!(!holds("size(R.holds.users) == 0;"));
    assert!(!holds("R.holds.done;"));
    assert!(holds("NOT{ R.holds.done; };"));
    assert!(!holds("R.holds.weight + 1 > 0;"));
}

/// An unset last step is NULL, which is equal to NULL and to nothing else, and is not a number.
#[test]
fn an_unset_attribute_is_null() {
    assert!(holds("R.holds == NULL;"));
    assert!(!holds("R.holds != NULL;"));
    assert!(!holds("R.holds == CUP;"));
    assert!(holds("R.holds != CUP;"));
    assert!(holds("R.holds == H.holds;"));
    assert!(!holds("CAN.weight < 1;"));
    assert!(!holds("CAN.weight >= 1;"));
    assert!(holds("CAN.weight != 0;"));
    assert!(!holds("CUP.done == false;"));
    assert!(!holds("CUP.done;"));
    assert!(!holds("R.helper >> BOX.users;"));
    assert!(holds("CUP.at != NULL;"));
    assert!(holds("CUP.at.near == SHELF;"));
    assert!(holds("CUP.at.near.near == NULL;"));
    assert!(!holds("CUP.at.near.near.near == NULL;"));
}

#[test]
fn numbers_are_compared_and_a_division_by_zero_has_no_value() {
    assert!(holds(
        "CUP.weight > 1; CUP.weight >= 2; CUP.weight < 3; CUP.weight <= 2;"
    ));
    assert!(!holds("CUP.weight > 2;"));
    assert!(!holds("CUP.weight < 2;"));
    assert!(holds("CUP.weight * 3 - 4 / 2 + -1 == 3;"));
    assert!(holds("(CUP.weight + 1) * 2 == 6;"));
    for test in [
        "1 / (CUP.weight - 2) > 0;",
        "1 / (CUP.weight - 2) == 1 / (CUP.weight - 2);",
    ] {
        assert!(!holds(test), "{test}");
    }
    assert!(holds("0 / (CUP.weight - 2) != 0;"));
}

#[test]
fn forall_and_exist_go_over_the_entities_that_pass_the_guard() {
    assert!(holds("FORALL(Object O, {O.weight != NULL;}, {O.weight >= 1;});"));
    assert!(!holds("FORALL(Object O, {}, {O.weight >= 1;});"));
    assert!(holds("FORALL(Object O, {O.weight > 7;}, {O.done == true;});"));
    assert!(holds("EXIST(Object O, {O.weight == 1;}, {H >> O.users;});"));
    assert!(!holds("EXIST(Object O, {O.weight == 2;}, {H >> O.users;});"));
    assert!(holds("EXIST(Object O, {O.weight == 1;});"));
    assert!(!holds("EXIST(Object O, {O.weight == 9;});"));
    assert!(holds(
        "FORALL(Object O, {O.weight == 2;}, {EXIST(Object P, {P != O;}, {P.weight == O.weight;});});"
    ));
    assert!(!holds(
        "FORALL(Object O, {O.weight != NULL;}, {EXIST(Object P, {P != O;}, {P.weight == O.weight;});});"
    ));
}

#[test]
fn or_and_not() {
    assert!(holds("OR{ CUP.weight == 9; }{ CUP.weight == 2; };"));
    assert!(!holds("OR{ CUP.weight == 9; }{ CUP.weight == 2; CUP.done; };"));
    assert!(holds("NOT{ CUP.weight == 2; CUP.done; };"));
    assert!(!holds("NOT{ CUP.weight == 2; CUP.at == TABLE; };"));
    assert!(holds("NOT{ NOT{ CUP.weight == 2; }; };"));
}

#[test]
fn effects_run_in_order_and_see_what_the_ones_before_have_changed() {
    assert!(after("R.holds = CUP; R.holds.at = SHELF;", "CUP.at == SHELF;"));
    assert!(after(
        "R.count = 1; R.count = R.count + 1; H.count = R.count;",
        "H.count == 2;"
    ));
    assert!(after("CUP.at = NULL;", "CUP.at == NULL;"));
    assert!(after(
        "CUP.done = true; IF{ CUP.done; }{ R.count = 1; };",
        "R.count == 1;"
    ));
    assert!(after(
        "IF{ CUP.done; }{ R.count = 1; } ELSE { R.count = 2; };",
        "R.count == 2;"
    ));
    assert!(after("IF{ CUP.done; }{ R.count = 1; };", "R.count == NULL;"));
    assert!(after(
        "FORALL(Object O, {O.weight == 2;}, {O.done = true; R.count = O.weight;});",
        "CUP.done; PEN.done; BOX.done == NULL; R.count == 2;"
    ));
    // The second object's guard sees what the first one's effects did.
    assert!(after(
        "FORALL(Object O, {R.count == NULL;}, {O.done = true; R.count = 1;});",
        "CUP.done; BOX.done == NULL; PEN.done == NULL;"
    ));
}

/// An effect whose target or value is a path through NULL changes nothing.
#[test]
fn an_effect_through_null_changes_nothing() {
    assert!(after(
        "R.holds.at = SHELF; R.holds.users <<= H;",
        "FORALL(Object O, {}, {O.at != SHELF;}); size(BOX.users) == 1;"
    ));
    assert!(after("CUP.at = R.holds.at;", "CUP.at == TABLE;"));
    assert!(after(
        "CUP.users <<= R.helper; BOX.users =>> R.helper.helper;",
        "size(CUP.users) == 0; size(BOX.users) == 1;"
    ));
    assert!(after("R.count = H.count + 1;", "R.count == NULL;"));
    assert!(after("CUP.weight = 1 / (CUP.weight - 2);", "CUP.weight == 2;"));
    // Through no NULL: the value is NULL, and is assigned.
    assert!(after("CUP.at = PEN.at;", "CUP.at == NULL;"));
}

#[test]
fn sets_grow_and_shrink() {
    assert!(after(
        "CUP.users <<= R; CUP.users <<= R; CUP.users <<= H;",
        "size(CUP.users) == 2; R >> CUP.users;"
    ));
    assert!(after(
        "BOX.users =>> H; BOX.users =>> R;",
        "size(BOX.users) == 0; H !>> BOX.users; BOX.users == CUP.users;"
    ));
    assert!(after("CUP.users = [R, H]; CUP.users =>> R;", "CUP.users == BOX.users;"));
    assert!(after(
        "CUP.users = BOX.users + R;",
        "CUP.users == [H, R]; BOX.users == [H];"
    ));
    assert!(after("CUP.users = BOX.users - H;", "CUP.users == [];"));
    assert!(after("CUP.users = [R, H] - R;", "CUP.users == [H];"));
    assert!(after("CUP.users = [];", "CUP.users == [];"));
}

/// `+` and `-` with an element that is NULL, and a list with one, have no value.
#[test]
fn sets_with_null_have_no_value() {
    assert!(!holds("[R, R.helper] == [R];"));
    assert!(!holds("BOX.users + R.helper == BOX.users;"));
    assert!(!holds("BOX.users - R.helper == BOX.users;"));
    assert!(!holds("size([R.helper]) == 0;"));
}

#[test]
fn parameters_may_be_sets() {
    let run = symbolic(
        &text(
            "method Go(Agent A) { { subtasks { 1: All(A, [CUP, PEN]); }; } }
             method All(Agent A, set Object Os) {
               goal { size(Os) == 0; }
               { subtasks { O = SELECT(Object, {O >> Os;}); 1: Mark(A, O); 2: All(A, Os - O) > 1; }; } }",
        ),
        "Go(R)",
    );
    assert_eq!(run.plan(), "Mark(R,CUP) Mark(R,PEN)");
    let arguments = &run.document().decomposition.children[0].children[1].arguments;
    assert_eq!(arguments, &["R", "[PEN]"]);
}
