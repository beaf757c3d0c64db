/* Vouching: one member goes on though another one does not hear it, as a third one hears both.
 *
 * Broker 0 speaks, in a view with 1 and 2 and, with OTHERS, so many more, who echo 0 always and
 * promise nothing. 1 and 2 may go on without 0 together, or 2 alone. README.md says what is
 * abstracted. A macro leaves one sentence out, and the search must find an error then.
 *
 * Time counts in parts of a term, TERM of them. What is older than three terms has one age.
 */
#ifndef TERM
#define TERM 2
#endif
#ifndef OTHERS
#define OTHERS 0
#endif
#define MEMBERS (3 + OTHERS)
#define OLD (3 * TERM)

/* How old the newest tick of 0 is that 1 heard, and so on. They echo it. */
byte heard_0_at_1, heard_0_at_2, heard_1_at_2, heard_2_at_1;
/* How old the newest tick of 0 is of which 0 knows that 1 echoed it, and so on. */
byte echo_of_1_at_0, echo_of_2_at_0, echo_of_1_at_2, echo_of_2_at_1;
/* With that echo at 0, 1 vouched for 2, and 2 for 1. */
bit vouched_by_1, vouched_by_2;
/* What 1 and 2 promised: a view of the two, or without 0 and 1. */
bit together_1, together_2, alone_2;

/* --- speaking */

/* What a third one says of another member is a term old. */
#ifdef VOUCHED_WORD_IS_NEW
#define vouched_for (3 * TERM)
#else
#define vouched_for (2 * TERM)
#endif
#ifdef NO_VOUCHING
#define vouches(vouched, echo) false
#else
#define vouches(vouched, echo) ((vouched) && (echo) < vouched_for)
#endif
#define within_a_term (1 + OTHERS + (echo_of_1_at_0 < TERM) + (echo_of_2_at_0 < TERM))
#define word_of_1 (echo_of_1_at_0 < 3 * TERM || vouches(vouched_by_2, echo_of_2_at_0))
#define word_of_2 (echo_of_2_at_0 < 3 * TERM || vouches(vouched_by_1, echo_of_1_at_0))
#define may_speak (2 * within_a_term > MEMBERS && word_of_1 && word_of_2)

/* --- heartbeats: each brings a tick, and echoes */

/* A member that echoed nothing for a term is not vouched for. */
#ifdef VOUCHES_FOR_THE_SILENT
#define is_vouched_for(echo) true
#else
#define is_vouched_for(echo) ((echo) < TERM)
#endif

inline from_0_to_1() {
    heard_0_at_1 = (together_1 -> heard_0_at_1 : 0)
}
inline from_0_to_2() {
    heard_0_at_2 = (together_2 || alone_2 -> heard_0_at_2 : 0)
}
inline from_1_to_0() {
    if
    :: !together_1 -> echo_of_1_at_0 = heard_0_at_1; vouched_by_1 = is_vouched_for(echo_of_2_at_1)
    :: else
    fi
}
inline from_2_to_0() {
    if
    :: !together_2 && !alone_2 ->
        echo_of_2_at_0 = heard_0_at_2;
        vouched_by_2 = is_vouched_for(echo_of_1_at_2)
    :: else
    fi
}
inline from_1_to_2() {
    heard_1_at_2 = (alone_2 -> heard_1_at_2 : 0);
    echo_of_1_at_2 = heard_2_at_1
}
inline from_2_to_1() {
    heard_2_at_1 = 0;
    echo_of_2_at_1 = (alone_2 -> echo_of_2_at_1 : heard_1_at_2)
}

#define older(age, most) age = (age < most -> age + 1 : most)
inline time_passes() {
    older(heard_0_at_1, OLD);
    older(heard_0_at_2, OLD);
    older(heard_1_at_2, OLD);
    older(heard_2_at_1, OLD);
    older(echo_of_1_at_0, OLD);
    older(echo_of_2_at_0, OLD);
    older(echo_of_1_at_2, TERM);
    older(echo_of_2_at_1, TERM)
}

/* --- views */

/* Three terms when less than half of the view goes on, one else. */
#define wait_of(size) (2 * (size) < MEMBERS -> 3 * TERM : TERM)

inline promise_at_1() {
    heard_0_at_1 >= wait_of(2) -> together_1 = 1
}
inline promise_at_2() {
    heard_0_at_2 >= wait_of(2) -> together_2 = 1
}
inline promise_alone() {
    heard_0_at_2 >= wait_of(1) && heard_1_at_2 >= wait_of(1) -> alone_2 = 1
}

/* I1: in each view without 0 there is a member of the view of 0. */
#define one_speaker() assert(!(may_speak && (alone_2 || (together_1 && together_2))))

#ifdef SERVED
/* 0 and 2 hear each other now and then, or never. The others do in every part of a term. */
bit came_0_at_1, came_1_at_0, came_1_at_2, came_2_at_1;
#define all_came (came_0_at_1 && came_1_at_0 && came_1_at_2 && came_2_at_1)
#define forget_what_came() came_0_at_1 = 0; came_1_at_0 = 0; came_1_at_2 = 0; came_2_at_1 = 0

init {
    do
    :: d_step { from_0_to_1(); came_0_at_1 = 1; assert(may_speak) }
    :: d_step { from_1_to_0(); came_1_at_0 = 1; assert(may_speak) }
    :: d_step { from_1_to_2(); came_1_at_2 = 1; assert(may_speak) }
    :: d_step { from_2_to_1(); came_2_at_1 = 1; assert(may_speak) }
    :: d_step { from_0_to_2(); assert(may_speak) }
    :: d_step { from_2_to_0(); assert(may_speak) }
    :: d_step { all_came -> forget_what_came(); time_passes(); assert(may_speak) }
    od
}
#else
init {
    do
    :: d_step { from_0_to_1(); one_speaker() }
    :: d_step { from_0_to_2(); one_speaker() }
    :: d_step { from_1_to_0(); one_speaker() }
    :: d_step { from_2_to_0(); one_speaker() }
    :: d_step { from_1_to_2(); one_speaker() }
    :: d_step { from_2_to_1(); one_speaker() }
    :: d_step { promise_at_1(); one_speaker() }
    :: d_step { promise_at_2(); one_speaker() }
    :: d_step { promise_alone(); one_speaker() }
    :: d_step { time_passes(); one_speaker() }
    od
}
#endif
