#include "romano/mqttsn/codec.h"

namespace romano::mqttsn {

std::string_view name_of(MsgType type) {
    switch (type) {
        case MsgType::advertise:
            return "ADVERTISE";
        case MsgType::searchgw:
            return "SEARCHGW";
        case MsgType::gwinfo:
            return "GWINFO";
        case MsgType::connect:
            return "CONNECT";
        case MsgType::connack:
            return "CONNACK";
        case MsgType::willtopicreq:
            return "WILLTOPICREQ";
        case MsgType::willtopic:
            return "WILLTOPIC";
        case MsgType::willmsgreq:
            return "WILLMSGREQ";
        case MsgType::willmsg:
            return "WILLMSG";
        case MsgType::register_:
            return "REGISTER";
        case MsgType::regack:
            return "REGACK";
        case MsgType::publish:
            return "PUBLISH";
        case MsgType::puback:
            return "PUBACK";
        case MsgType::pubcomp:
            return "PUBCOMP";
        case MsgType::pubrec:
            return "PUBREC";
        case MsgType::pubrel:
            return "PUBREL";
        case MsgType::subscribe:
            return "SUBSCRIBE";
        case MsgType::suback:
            return "SUBACK";
        case MsgType::unsubscribe:
            return "UNSUBSCRIBE";
        case MsgType::unsuback:
            return "UNSUBACK";
        case MsgType::pingreq:
            return "PINGREQ";
        case MsgType::pingresp:
            return "PINGRESP";
        case MsgType::disconnect:
            return "DISCONNECT";
        case MsgType::willtopicupd:
            return "WILLTOPICUPD";
        case MsgType::willtopicresp:
            return "WILLTOPICRESP";
        case MsgType::willmsgupd:
            return "WILLMSGUPD";
        case MsgType::willmsgresp:
            return "WILLMSGRESP";
        case MsgType::encapsulated:
            return "ENCAPSULATED";
    }
    return "RESERVED";
}

MsgType type_of(const Message& message) {
    return std::visit([]<typename M>(const M&) { return M::type; }, message);
}

}  // namespace romano::mqttsn
