// How many fields an aggregate has: a test that says the number fails to compile when a field is
// added, and so reminds its author of the conversion.
#pragma once

#include <cstddef>
#include <utility>

namespace romano::dds {

struct AnyField {
    template <typename T>
    operator T() const;
};

template <typename T, std::size_t... I>
consteval bool takes(std::index_sequence<I...>) {
    return requires {
        T{(static_cast<void>(I), AnyField{})...};
    };
}

template <typename T, std::size_t Count = 0>
consteval std::size_t field_count() {
    if constexpr (takes<T>(std::make_index_sequence<Count + 1>{})) {
        return field_count<T, Count + 1>();
    } else {
        return Count;
    }
}

}  // namespace romano::dds
