#include "experiments/operator/loop_message_text.h"

#include <nlohmann/json.hpp>
#include <variant>

#include "experiments/operator/loop_request.h"
#include "experiments/operator/message_text.h"

namespace romano::experiments {
namespace {

using Json = nlohmann::ordered_json;

std::string_view name_of(control::Fallback fallback) {
    switch (fallback) {
        case control::Fallback::stop:
            return "stop";
        case control::Fallback::hold:
            return "hold";
        case control::Fallback::own_law:
            return "own-law";
    }
    return {};
}

template <typename Number>
auto number_of(Number number) {
    return static_cast<std::uint32_t>(number);
}

struct LoopWords {
    Json operator()(const control::Ask& m) const {
        return {{"type", "loop-ask"}, {"channel", number_of(m.channel)}, {"asker", m.asker.text()}};
    }
    Json operator()(const control::Open& m) const {
        return {{"type", "loop-open"},
                {"channel", number_of(m.channel)},
                {"ticket", number_of(m.ticket)},
                {"asker", m.asker.text()},
                {"controller", m.controller.text()},
                {"law", number_of(m.law)},
                {"period_ms", m.period_ms},
                {"deadline_ms", m.deadline_ms},
                {"lease_s", m.lease_s},
                {"fallback", name_of(m.fallback)},
                {"ends_then", m.ends_then},
                {"parameters", hexadecimal(m.parameters)}};
    }
    Json operator()(const control::Renew& m) const {
        return {
            {"type", "loop-renew"}, {"session", number_of(m.session)}, {"asker", m.asker.text()}};
    }
    Json operator()(const control::End& m) const {
        return {{"type", "loop-end"}, {"session", number_of(m.session)}, {"asker", m.asker.text()}};
    }
    Json operator()(const control::Report& m) const {
        Json out{{"type", "loop-report"}};
        out.update(to_json(m));
        return out;
    }
    Json operator()(const control::Invite& m) const {
        return {{"type", "loop-invite"},        {"session", number_of(m.session)},
                {"plant", m.plant.text()},      {"channel", number_of(m.channel)},
                {"law", number_of(m.law)},      {"period_ms", m.period_ms},
                {"deadline_ms", m.deadline_ms}, {"parameters", hexadecimal(m.parameters)}};
    }
    Json operator()(const control::Answer& m) const {
        return {{"type", "loop-answer"},
                {"session", number_of(m.session)},
                {"reason", control::name_of(m.reason)}};
    }
    Json operator()(const control::Sample& m) const {
        Json out{{"type", "loop-sample"},
                 {"session", number_of(m.session)},
                 {"sequence", m.sequence},
                 {"tick_us", m.tick}};
        if (m.age != control::Sample::no_age) out["last_age_ms"] = m.age / 10.0;
        out["value"] = hexadecimal(m.value);
        return out;
    }
    Json operator()(const control::Command& m) const {
        return {{"type", "loop-command"},
                {"session", number_of(m.session)},
                {"sequence", m.sequence},
                {"tick_us", m.tick},
                {"value", hexadecimal(m.value)}};
    }
    Json operator()(const control::Bye& m) const {
        return {{"type", "loop-bye"},
                {"session", number_of(m.session)},
                {"reason", control::name_of(m.reason)}};
    }
};

}  // namespace

nlohmann::ordered_json to_json(const control::Message& message) {
    return std::visit(LoopWords{}, message);
}

}  // namespace romano::experiments
