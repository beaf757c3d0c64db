/* Who may speak from one shard: views, promises, seals and the lease (mechanisms 1, 2 and 4).
 *
 * README.md says what is abstracted and why that loses no error. Every inline is one step of the
 * protocol. A macro NO_... or ..._... leaves one sentence out, and
 * the search must find an error then; REACH_... asks whether something can happen at all.
 *
 *   N brokers, K view changes; view 0 has all of them, and broker 0 owns the shard.
 */
#ifndef N
#define N 3
#endif
#ifndef K
#define K 3
#endif
#define VIEWS (K + 1)
#define ALL ((1 << N) - 1)
#define bit(b) (1 << (b))
#define has(set, b) (((set) >> (b)) & 1)
#define size(set) (has(set, 0) + has(set, 1) + has(set, 2) + has(set, 3))

/* A view, by its number. */
byte members[VIEWS];
byte owner[VIEWS];
byte promisers[VIEWS]; /* members that have promised it; all of them: it may be announced */
byte former[VIEWS];    /* of these, who owned the shard then */
byte sealed[VIEWS];    /* who wrote Sealed{shard, this view} */
byte newest;           /* the highest number that was proposed */

/* A broker. */
byte promised[N];
byte installed[N];
byte refused[N]; /* whom it does not echo */
byte owns;       /* who has adopted the shard and not sealed it since */
byte ever_sealed;
byte dead;
/* 1 + the number in the oldest echo of q that p may still count; 0: none is younger than D.
 * By the same tick q waits, so that this is also what q waits for before it promises without p. */
byte echo[N * N];
#ifdef TIERS
/* The same for 3D: the second tier. */
byte late_echo[N * N];
byte promises[N]; /* views promised since the installed one, a bit each */
#endif

#define echo_of(q, p) echo[(q) * N + (p)]
#define late_echo_of(q, p) late_echo[(q) * N + (p)]

/* P counts an echo only if its number is not above its own view's. */
#ifdef ECHO_WITHOUT_NUMBER
#define counts(e, p) ((e) > 0)
#else
#define counts(e, p) ((e) > 0 && (e) <= installed[p] + 1)
#endif
/* The lease exempts nobody. */
#ifdef DEAD_EXEMPTED
#define vouches(q, p) ((q) == (p) || has(dead, q) || counts(echo_of(q, p), p))
#else
#define vouches(q, p) ((q) == (p) || counts(echo_of(q, p), p))
#endif
#define vouches_late(q, p) ((q) == (p) || counts(late_echo_of(q, p), p))

/* Temporaries, zero between the steps. */
byte b, q, n, m, o, v;
bit ok;
#define forget_temporaries() b = 0; q = 0; n = 0; m = 0; o = 0; v = 0; ok = 0

/* --- speaking */

/* Every former owner has sealed in this view; those that the view left out have no lease. */
#ifdef NO_SEAL
#define can_adopt(p) true
#else
#ifdef SEAL_WITHOUT_VIEW
#define can_adopt(p) ((former[installed[p]] & ~bit(p) & ~ever_sealed) == 0)
#else
#define can_adopt(p) ((former[installed[p]] & ~bit(p) & ~sealed[installed[p]]) == 0)
#endif
#endif

inline majority_vouches(p, view) {
    m = 0;
    q = 0;
    do
    :: q < N -> m = m + (has(members[view], q) && vouches(q, p)); q++
    :: else -> break
    od;
    ok = ok && (2 * m > size(members[view]))
}

/* ok: p may send from the shard. */
inline may_speak(p) {
    ok = has(owns, p) && !has(dead, p) && owner[installed[p]] == p;
#ifndef NO_SEAL
    /* It has adopted in the view that it is in: all that were active have sealed. */
    ok = ok && can_adopt(p);
#endif
#ifndef NO_LEASE
#ifdef TIERS
    if
    :: size(members[installed[p]]) == 2 -> all_vouch(p)
    :: else ->
        q = 0;
        do
        :: q < N -> ok = ok && (!has(members[installed[p]], q) || vouches_late(q, p)); q++
        :: else -> break
        od;
        majority_vouches(p, installed[p]);
#ifndef NO_JOINT_CONDITION
        v = 0;
        do
        :: v < VIEWS ->
            if
            :: has(promises[p], v) -> majority_vouches(p, v)
            :: else
            fi;
            v++
        :: else -> break
        od
#endif
    fi
#else
    all_vouch(p)
#endif
#endif
}

inline all_vouch(p) {
    q = 0;
    do
    :: q < N -> ok = ok && (!has(members[installed[p]], q) || vouches(q, p)); q++
    :: else -> break
    od
}

byte speakers;
/* I1: two that may speak at one moment are in views without a common member. */
inline assert_one_speaker() {
    speakers = 0;
    b = 0;
    do
    :: b < N -> may_speak(b); speakers = speakers | (ok << b); b++
    :: else -> break
    od;
#ifdef REACH_ANOTHER_SPEAKER
    assert(!has(speakers, 1));
#endif
#ifdef REACH_TWO_SIDES
    assert(!(has(speakers, 0) && has(speakers, 1)));
#endif
    b = 0;
    do
    :: b < N ->
        n = b + 1;
        do
        :: n < N ->
            assert(!(has(speakers, b) && has(speakers, n) &&
                     (members[installed[b]] & members[installed[n]])));
            n++
        :: else -> break
        od;
        b++
    :: else -> break
    od;
    speakers = 0;
    forget_temporaries()
}

/* --- seal and adopt */

/* Nobody begins an adoption in a view below its promise. */
#ifdef ADOPT_BELOW_PROMISE
#define is_free_to_adopt(p) true
#else
#define is_free_to_adopt(p) (promised[p] == installed[p])
#endif

inline adopt() {
    if
    :: !has(dead, b) && owner[installed[b]] == b && !has(owns, b) && is_free_to_adopt(b) &&
       can_adopt(b) -> owns = owns | bit(b)
    :: else
    fi
}

/* --- the lease */

/* From its promise of a view that leaves P out until it installs one with P, it does not echo P. */
inline echo_again(p, view) {
    q = 0;
    do
    :: q < N ->
        if
        :: has(members[view], q) && q != p ->
            refused[p] = refused[p] & ~bit(q);
            if
            :: echo_of(p, q) == 0 -> echo_of(p, q) = installed[p] + 1
            :: else
            fi;
#ifdef TIERS
            if
            :: late_echo_of(p, q) == 0 -> late_echo_of(p, q) = installed[p] + 1
            :: else
            fi
#endif
        :: else
        fi;
        q++
    :: else -> break
    od
}

/* D after the last tick of P that it echoed: P's lease from it is over. */
inline wait_for_leases(p, view) {
    q = 0;
    do
    :: q < N ->
        if
        :: !has(members[view], q) && q != p ->
#ifndef NO_WAIT
            echo_of(p, q) = 0;
#ifdef TIERS
            if
            :: ok -> late_echo_of(p, q) = 0
            :: else
            fi;
#endif
#endif
#ifndef ECHO_TO_ONE_LEFT_OUT
            refused[p] = refused[p] | bit(q);
#else
            if
            :: echo_of(p, q) == 0 -> echo_of(p, q) = installed[p] + 1
            :: else
            fi;
#endif
            skip
        :: else
        fi;
        q++
    :: else -> break
    od
}

#ifdef TIERS
/* ok: it keeps less than half of a view that it promised, from its installed one on: waits 3D. */
inline looks_for_halves(p, view) {
    ok = 2 * size(members[view] & members[installed[p]]) < size(members[installed[p]]) ||
         size(members[installed[p]]) == 2;
    q = 0;
    do
    :: q < VIEWS ->
        ok = ok || (has(promises[p], q) &&
                    2 * size(members[view] & members[q]) < size(members[q]));
        q++
    :: else -> break
    od
}
#endif

/* --- views */

inline some_broker() {
    if
    :: b = 0
    :: b = 1
#if N > 2
    :: b = 2
#endif
#if N > 3
    :: b = 3
#endif
    fi
}

/* I4: what a broker promised never falls. */
inline promise(p, view) {
    assert(promised[p] <= view);
    wait_before_promise(p, view);
    promised[p] = view;
    promisers[view] = promisers[view] | bit(p);
    former[view] = former[view] | (owns & bit(p));
#ifdef TIERS
    promises[p] = promises[p] | bit(view);
#endif
#ifdef ECHO_AGAIN_EARLY
    echo_again(p, view)
#endif
}

inline wait_before_promise(p, view) {
#ifdef TIERS
    looks_for_halves(p, view);
#endif
    wait_for_leases(p, view);
    ok = 0
}

inline some_members() {
    m = 1;
    do
    :: m < ALL -> m++
    :: break
    od
}

/* Anybody may suspect anybody: some broker proposes some view, and promises it first. */
inline propose() {
    if
    :: !has(dead, b) && has(m, b) && has(m, o) ->
        newest++;
        members[newest] = m;
        owner[newest] = o;
        promise(b, newest)
    :: else
    fi
}

inline some_owner() {
    if
    :: o = 0
    :: o = 1
#if N > 2
    :: o = 2
#endif
#if N > 3
    :: o = 3
#endif
    fi
}

inline some_view() {
    n = 1;
    do
    :: n < newest -> n++
    :: break
    od
}

/* A promise is given up for a higher number only. */
#ifdef OLDER_PROPOSAL_ANSWERED
#define is_new_to(p, view) true
#else
#define is_new_to(p, view) (promised[p] < view)
#endif

inline answer_proposal() {
    if
    :: !has(dead, b) && has(members[n], b) && is_new_to(b, n) -> promise(b, n)
    :: else
    fi
}

#ifdef INSTALL_BELOW_PROMISE
#define is_as_promised(p, view) true
#else
#define is_as_promised(p, view) (promised[p] <= view)
#endif

/* I4: nor does the number of its view fall. */
inline install() {
    if
    :: !has(dead, b) && has(members[n], b) && promisers[n] == members[n] && installed[b] < n &&
       is_as_promised(b, n) ->
        assert(installed[b] < n && promised[b] <= n);
        installed[b] = n;
        promised[b] = n;
#ifdef TIERS
        promises[b] = 0;
#endif
        echo_again(b, n);
        /* An owner that the view does not name seals; one that it does goes on. */
        if
        :: has(owns, b) && owner[n] != b ->
            owns = owns & ~bit(b);
            sealed[n] = sealed[n] | bit(b);
            ever_sealed = ever_sealed | bit(b)
        :: else
        fi
    :: else
    fi
}

#ifdef PROMISE_TIMES_OUT
inline time_out() {
    if
    :: promised[b] > installed[b] ->
        promised[b] = installed[b];
        echo_again(b, installed[b])
    :: else
    fi
}
#endif

init {
    d_step {
        members[0] = ALL;
        promisers[0] = ALL;
        owns = 1;
        b = 0;
        do
        :: b < N ->
            q = 0;
            do
            :: q < N && q != b ->
                echo_of(b, q) = 1;
#ifdef TIERS
                late_echo_of(b, q) = 1;
#endif
                q++
            :: q == b -> q++
            :: q >= N -> break
            od;
            b++
        :: else -> break
        od;
        forget_temporaries()
    }
    do
    :: atomic { newest < K -> some_broker(); some_members(); some_owner(); d_step { propose(); assert_one_speaker() } }
    :: atomic { newest > 0 -> some_broker(); some_view(); d_step { answer_proposal(); assert_one_speaker() } }
    :: atomic { newest > 0 -> some_broker(); some_view(); d_step { install(); assert_one_speaker() } }
    :: atomic { newest > 0 -> some_broker(); d_step { adopt(); assert_one_speaker() } }
#ifdef PROMISE_TIMES_OUT
    :: atomic { newest > 0 -> some_broker(); d_step { time_out(); assert_one_speaker() } }
#endif
#ifdef CRASH
    :: atomic { dead == 0 -> some_broker(); d_step { dead = bit(b); assert_one_speaker() } }
#endif
    od
}
