#include "overlay/dds/qos.h"

namespace romano::dds {
namespace {

Qos keep_last(std::int32_t depth) {
    Qos qos{dds_create_qos()};
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    return qos;
}

}  // namespace

Qos best_effort(std::int32_t depth) {
    Qos qos = keep_last(depth);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
    return qos;
}

Qos reliable(std::int32_t depth) {
    Qos qos = keep_last(depth);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(1));
    return qos;
}

Qos reliable_for_late_readers(std::int32_t depth, std::int32_t kept) {
    Qos qos = reliable(depth);
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, kept, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    return qos;
}

}  // namespace romano::dds
