// Any text as a rights file: rules, or a line that it has and a sentence for people. What rules
// say of a filter is what they say of its topics.

#include "broker/rights/rights.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "broker/protection/protected_node.h"
#include "romano/mqttsn/topic.h"
#include "tests/fuzz/require.h"

using namespace romano;
using namespace romano::rights;

namespace {

constexpr std::array<std::string_view, 8> topics = {"a",      "a/b",    "r1", "robots/r1/pose",
                                                    "$SYS/a", "common", "/",  "a/b/c"};
constexpr std::array<std::string_view, 6> filters = {"#", "+", "a/#", "+/b/#", "$SYS/#", "+/r1/+"};
constexpr Endpoint at_plain{.address = {127, 0, 0, 1}, .port = 1, .family = Endpoint::Family::ipv4};

Endpoint at_sealed() {
    Endpoint via = at_plain;
    via.packets = Endpoint::Packets::sealed;
    return via;
}

void look_at(const Rights& rights, const broker::Speaker& who) {
    for (const std::string_view topic : topics) {
        if (rights.may_publish(who, topic, as_octets("x"))) {
            REQUIRE(rights.may_publish_something(who, topic));
        }
    }
    for (const std::string_view filter : filters) {
        const auto extent = rights.may_read_of(who, filter);
        for (const std::string_view topic : topics) {
            if (!mqttsn::matches(filter, topic)) continue;
            const bool may = rights.may_read(who, topic);
            REQUIRE(may ? extent != broker::Extent::none : extent != broker::Extent::all);
        }
    }
    REQUIRE(!rights.name_of(who).empty());
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view text = as_text({data, size});
    const auto rules = parse(text);
    if (!rules) {
        const auto lines = 1 + std::ranges::count(text, '\n');
        REQUIRE(rules.error().line >= 1);
        REQUIRE(rules.error().line <= static_cast<unsigned long>(lines));
        REQUIRE(!rules.error().what.empty() && rules.error().what.size() < 300);
        REQUIRE(std::ranges::all_of(rules.error().what, [](char c) { return c >= ' '; }));
        return 0;
    }
    REQUIRE(digest_of(*rules).size() == 16);
    const std::array<KeyOwner, 2> owners{KeyOwner{"r1", Role::robot}, {"anna", Role::person}};
    const Rights rights(*rules, owners);
    for (const std::string id : {"r1", "anna/2", "nobody"}) {
        const std::string node_id = broker::protected_node_id(id);
        look_at(rights, {at_sealed(), node_id, id});
        look_at(rights, {at_plain, node_id, id});
    }
    look_at(rights, {at_plain, {}, {}});
    look_at(rights, {.via = {}, .node_id = {}, .client_id = {}, .is_owner = true});
    return 0;
}
