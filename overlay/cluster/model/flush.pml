/* What a view agrees on about the log of a former owner: promises, ends, tails, raised ends
 * (mechanism 3), followed by one write that clients may be shown.
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
#define K 2
#endif
#define VIEWS (K + 1)
#define ALL ((1 << N) - 1)
#define bit(b) (1 << (b))
#define has(set, b) (((set) >> (b)) & 1)
#define is_one(set) ((set) && !((set) & ((set) - 1)))

/* A view, by its number. */
byte members[VIEWS];
byte owner[VIEWS];
byte before[VIEWS];    /* who was with the proposer before: the others are newcomers */
byte promisers[VIEWS]; /* who has promised it, and with that: */
byte holders[VIEWS];   /* who held the write then */
byte former[VIEWS];    /* owners whose Adopted one of them held */
byte at_work[VIEWS];    /* who owned the shard then */
byte ended[VIEWS];     /* who knew that the writer's log has ended without the write */
byte carried[VIEWS];   /* owners of whose state it was known to have the write */
byte sealed[VIEWS];    /* who wrote Sealed{shard, this view} */
byte sealed_with[VIEWS]; /* of these, whose state had the write */
byte announced;        /* views */
byte newest;           /* the highest number that was proposed */

/* A broker. */
byte promised[N];
byte installed[N];
byte refused[N]; /* whom it does not echo */
byte frozen[N];  /* whose logs it takes nothing of */
byte knows[N];   /* owners whose Adopted it holds */
byte knows_with[N]; /* of these, whose Adopted names the write */
byte owns;       /* who has adopted the shard and not sealed it since */
byte ever_owned;
byte dead;

/* The write. */
byte writer = N; /* N: nobody yet */
byte wrote_in;   /* the view */
byte holds;      /* who has it, in the writer's log */
byte carries;    /* whose state of the shard has it */
bit shown;       /* to a client */

#define is_written (writer < N)
/* Members that the view leaves out have an end: this one has the write in it. */
#ifdef ENDS_ARE_NEVER_RAISED
#define end_has_write(v) (is_written && !has(members[v], writer) && holders[v] && !ended[v])
#else
#define end_has_write(v) (is_written && !has(members[v], writer) && holders[v])
#endif

/* Temporaries, zero between the steps. */
byte b, q, n, m, o, v;
bit ok;
#define forget_temporaries() b = 0; q = 0; n = 0; m = 0; o = 0; v = 0; ok = 0

/* The lease (speak.pml), without its time: q vouches for p while q has promised no view without p,
 * unless it has installed one with p since, and no view that p does not know yet. */
#define vouches(q, p) (!has(refused[q], p) && installed[q] <= installed[p])

/* ok: p may send from the shard. */
inline may_speak(p) {
    ok = has(owns, p) && !has(dead, p);
    q = 0;
    do
    :: q < N -> ok = ok && (q == p || !has(members[installed[p]], q) || vouches(q, p)); q++
    :: else -> break
    od
}

/* What is in the state that an owner begins with. A former owner sealed with the write; or it was
 * left out with an end that has it; or it was not at work, for it had sealed in a view whose owner
 * did not come to adopt; or somebody adopted it since, and whoever knows that holds it. */
#ifdef ONLY_WHO_IS_AT_WORK
#define known_with(v) (carried[v] & ~bit(writer) & ~members[v])
#else
#define known_with(v) (carried[v] & ~(bit(writer) & ~members[v]))
#endif
#define needs_write(v) (is_written && (sealed_with[v] || known_with(v) || \
                        (has(former[v], writer) && end_has_write(v))))

/* After every step. */
inline assert_invariants() {
    b = 0;
    do
    :: b < N && !has(dead, b) ->
        v = installed[b];
        /* I2: who was a member before holds a removed log up to its end, and nothing beyond. */
        if
        :: v > 0 && is_written && !has(members[v], writer) ->
            assert(!end_has_write(v) || !has(before[v], b) || has(holds, b));
            /* Tails of the next view may have come. */
            assert(end_has_write(v) || !has(holds, b) || end_has_write(promised[b]))
        :: else
        fi;
        /* I3: what was shown, and a promiser of a later view held, is in the state of its owner. */
        if
        :: has(owns, b) && shown && v > wrote_in && holders[v] -> assert(has(carries, b))
        :: else
        fi;
        /* I5: and so is what a former owner had when it sealed. */
        if
        :: has(owns, b) && sealed_with[v] -> assert(has(carries, b))
        :: else
        fi;
#ifdef REACH_ADOPTED_WRITE
        assert(!(has(owns, b) && shown && writer != b && has(carries, b)));
#endif
#ifdef REACH_RAISED_END
        assert(!(has(owns, b) && shown && end_has_write(v) && ended[v]));
#endif
        b++
    :: b < N && has(dead, b) -> b++
    :: b >= N -> break
    od;
    forget_temporaries()
}

/* --- a log, its writer's and everybody's */

inline write() {
    may_speak(b);
    if
    :: ok && !is_written ->
        writer = b;
        wrote_in = installed[b];
        holds = bit(b);
        carries = bit(b);
        knows_with[b] = knows_with[b] | bit(b)
    :: else
    fi
}

/* Batches come late or not at all, but in order: Adopted stands before the write. */
inline take_adopted() {
    if
    :: !has(dead, b) && has(ever_owned, o) && !has(frozen[b], o) &&
       (!has(carries, o) || has(holds, b)) -> /* what it names is held */
        knows[b] = knows[b] | bit(o);
        knows_with[b] = knows_with[b] | (carries & bit(o))
    :: else
    fi
}
inline take_write() {
    if
    :: is_written && !has(dead, b) && !has(frozen[b], writer) ->
        knows[b] = knows[b] | bit(writer);
        holds = holds | bit(b)
    :: else
    fi
}

/* acks = 1; alone it answers at once. */
inline show_it() {
    if
    :: is_written ->
        may_speak(writer);
        m = members[installed[writer]];
        if
        :: ok && (is_one(m) || (holds & m & members[promised[writer]] & ~bit(writer))) -> shown = 1
        :: else
        fi
    :: else
    fi
}

/* --- views */

inline some_broker() {
    if
    :: b = 0
    :: b = 1
    :: b = 2
    fi
}
inline some_owner() {
    if
    :: o = 0
    :: o = 1
    :: o = 2
    fi
}
inline some_members() {
    m = 1;
    do
    :: m < ALL -> m++
    :: break
    od
}
inline some_view() {
    n = 1;
    do
    :: n < newest -> n++
    :: break
    od
}

/* The promise, what it freezes, and the report. */
inline promise(p, view) {
    promised[p] = view;
    promisers[view] = promisers[view] | bit(p);
    refused[p] = refused[p] | (ALL & ~members[view]);
#ifndef NO_FREEZE
    frozen[p] = frozen[p] | (ALL & ~members[view]);
#endif
    holders[view] = holders[view] | (holds & bit(p));
    at_work[view] = at_work[view] | (owns & bit(p));
#ifdef OWNERS_FROM_INSTALLED_VIEWS
    former[view] = former[view] | bit(owner[installed[p]]);
#else
    former[view] = former[view] | knows[p];
#endif
    carried[view] = carried[view] | knows_with[p];
    if
    :: is_written && !has(members[installed[p]], writer) && !end_has_write(installed[p]) ->
        ended[view] = ended[view] | bit(p)
    :: else
    fi
}

inline propose() {
    if
    :: !has(dead, b) && has(m, b) && has(m, o) ->
        newest++;
        members[newest] = m;
        owner[newest] = o;
        before[newest] = members[installed[b]] & m;
        promise(b, newest)
    :: else
    fi
}

/* A promise is given up for a higher number only. */
inline answer_proposal() {
    if
    :: !has(dead, b) && has(members[n], b) && promised[b] < n -> promise(b, n)
    :: else
    fi
}

/* A missing tail, from a member that holds it; a newcomer fetches later. */
inline send_tail() {
    if
    :: end_has_write(n) && promisers[n] == members[n] && has(members[n], b) && !has(dead, b) &&
       (promised[b] == n || installed[b] == n) && (holds & members[n] & ~dead) ->
        holds = holds | bit(b)
    :: else
    fi
}

/* Who was a member before holds the end before the announcement. */
inline announce() {
#ifdef TAILS_AFTER_THE_ANNOUNCEMENT
    if
    :: promisers[n] == members[n] -> announced = announced | bit(n)
    :: else
    fi
#else
    if
    :: promisers[n] == members[n] && (!end_has_write(n) || !(before[n] & ~holds)) ->
        announced = announced | bit(n)
    :: else
    fi
#endif
}

inline install() {
    if
    :: !has(dead, b) && has(members[n], b) && has(announced, n) && installed[b] < n &&
       promised[b] <= n ->
        /* Whoever did not hear the proposal has not promised, and then there is no announcement. */
        installed[b] = n;
        promised[b] = n;
        refused[b] = ALL & ~members[n];
        frozen[b] = ALL & ~members[n];
        /* An owner seals, and adopts anew where the view names it: others may have to be joined. */
        if
        :: has(owns, b) ->
            owns = owns & ~bit(b);
            sealed[n] = sealed[n] | bit(b);
            sealed_with[n] = sealed_with[n] | (carries & bit(b))
        :: else
        fi
    :: else
    fi
}

/* --- seal and adopt */

inline adopt() {
    v = installed[b];
    ok = !has(dead, b) && owner[v] == b && !has(owns, b) && promised[b] == v && v > 0;
#ifndef NO_SEAL
    ok = ok && !(at_work[v] & ~sealed[v]);
#endif
#ifndef NEWCOMER_OWNS_AT_ONCE
    /* By reference: what it adopts it holds. */
    ok = ok && (!needs_write(v) || has(holds, b));
#endif
    if
    :: ok ->
        if
        :: needs_write(v) && has(holds, b) -> carries = carries | bit(b)
        :: else -> carries = carries & ~bit(b)
        fi;
        owns = owns | bit(b);
        ever_owned = ever_owned | bit(b);
        knows[b] = knows[b] | bit(b);
        knows_with[b] = (knows_with[b] & ~bit(b)) | (carries & bit(b))
    :: else
    fi
}
/* What a sealed log still brings. */
inline take_up_to_the_seal() {
    v = installed[b];
    if
    :: is_written && !has(dead, b) && promised[b] == v && v > 0 &&
       (sealed_with[v] & ~dead) ->
        holds = holds | bit(b);
        knows[b] = knows[b] | bit(writer)
    :: else
    fi
}

init {
    d_step {
        members[0] = ALL;
        promisers[0] = ALL;
        announced = 1;
        owns = 1;
        ever_owned = 1;
        b = 0;
        do
        :: b < N -> knows[b] = 1; b++
        :: else -> break
        od;
        forget_temporaries()
    }
    do
    :: atomic { newest < K -> some_broker(); some_members(); some_owner(); d_step { propose(); assert_invariants() } }
    :: atomic { newest > 0 -> some_broker(); some_view(); d_step { answer_proposal(); assert_invariants() } }
    :: atomic { newest > 0 -> some_view(); d_step { announce(); assert_invariants() } }
    :: atomic { newest > 0 -> some_broker(); some_view(); d_step { install(); assert_invariants() } }
    :: atomic { newest > 0 -> some_broker(); d_step { adopt(); assert_invariants() } }
    :: atomic { newest > 0 -> some_broker(); some_view(); d_step { send_tail(); assert_invariants() } }
    :: atomic { newest > 0 -> some_broker(); d_step { take_up_to_the_seal(); assert_invariants() } }
    :: atomic { newest > 0 -> some_broker(); some_owner(); d_step { take_adopted(); assert_invariants() } }
    :: atomic { !is_written -> some_broker(); d_step { write(); assert_invariants() } }
    :: atomic { is_written -> some_broker(); d_step { take_write(); assert_invariants() } }
    :: atomic { is_written && !shown -> d_step { show_it(); assert_invariants() } }
#ifdef CRASH
    :: atomic { dead == 0 -> some_broker(); d_step { dead = bit(b); assert_invariants() } }
#endif
    od
}
