// The end of an MCAP file: what is in it, and where each message is. All of it is read off the data
// section that stands in the file, so that the writer keeps nothing for it, however long it
// records.
#pragma once

#include <cstdint>
#include <functional>

#include "experiments/mcap/file_walk.h"

namespace romano::experiments::mcap {

/// Takes octets that are to be appended; false when that failed.
using Append = std::function<bool(Bytes)>;

/// `data_section`: a file as it is before its end, whose channels stand outside of the chunks, as
/// ChunkWriter writes them. Gives the octets up to the last one of the file, about a MB at a time;
/// false when `append` failed.
[[nodiscard]] bool append_summary(OctetSource& data_section, const Append& append);

}  // namespace romano::experiments::mcap
