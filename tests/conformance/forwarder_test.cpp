// Section 5.5: clients behind a forwarder.

#include "tests/conformance/suite.h"

namespace romano::conformance::forwarder_test {
namespace {

class Forwarding : public PatientSuite {
protected:
    /// The client behind node id `node` connects through the forwarder.
    void connects_through(Client& forwarder, std::string_view node, const std::string& id) {
        forwarder.says(encapsulated(node, connect(id)));
        forwarder.hears(encapsulated(node, connack(accepted)));
    }
    /// What it answers; REGACK and SUBACK carry the id at these places.
    unsigned subscribes_through(Client& forwarder, const std::string& node,
                                const std::string& name) {
        forwarder.says(encapsulated(node, subscribe(no_flags, 5, name)));
        const Octets answer = forwarder.next();
        const std::size_t at = 3 + node.size() + 3;
        if (answer.size() < at + 2) {
            ADD_FAILURE() << describe(answer);
            return 0;
        }
        const auto id = static_cast<unsigned>(answer[at] << 8U | answer[at + 1]);
        EXPECT_EQ(answer, encapsulated(node, suback(no_flags, id, 5)));
        return id;
    }
};

CONFORMANCE_SUITE(S5_5_Forwarder, Forwarding);

TEST_P(S5_5_Forwarder, c_AnswersGoBackInTheSameWrapping) {
    Client& forwarder = client();
    connects_through(forwarder, "n1", unique("f"));
    forwarder.says(encapsulated("n1", pingreq()));
    forwarder.hears(encapsulated("n1", pingresp()));
}

TEST_P(S5_5_Forwarder, c_EachNodeIsAClientOfItsOwn) {
    Client& forwarder = client();
    connects_through(forwarder, "n1", unique("f"));
    connects_through(forwarder, "n2", unique("f"));
    const unsigned id = subscribes_through(forwarder, "n1", topic());
    Client& publisher = connected();
    publisher.publishes(publisher.registers(topic()), "x");
    forwarder.hears(encapsulated("n1", publish(no_flags, id, 0, "x")));
    hears_nothing(forwarder);  // nothing to n2
}

TEST_P(S5_5_Forwarder, c_AForwarderCanBeAClientItself) {
    Client& forwarder = connected();
    connects_through(forwarder, "n1", unique("f"));
    forwarder.says(pingreq());
    forwarder.hears(pingresp());
    forwarder.says(encapsulated("n1", disconnect()));
    forwarder.hears(encapsulated("n1", disconnect()));
    forwarder.says(pingreq());
    forwarder.hears(pingresp());
}

TEST_P(S5_5_Forwarder, c_TheSameNodeIdBehindAnotherForwarderIsAnotherClient) {
    Client& one = client();
    Client& other = client();
    connects_through(one, "n1", unique("f"));
    other.says(encapsulated("n1", pingreq()));
    other.hears(encapsulated("n1", disconnect()));  // G8: nobody's
}

TEST_P(S5_5_Forwarder, c_NodeIdsAreOpaqueAndOfAnyLength) {
    Client& forwarder = client();
    connects_through(forwarder, std::string(1, '\0'), unique("f"));
    connects_through(forwarder, std::string(2, '\0'), unique("f"));
    connects_through(forwarder, std::string(252, '\xFF'), unique("f"));  // as long as fits
}

TEST_P(S5_5_Forwarder, a_TheMessageHasALengthOfItsOwn) {
    Client& forwarder = client();
    connects_through(forwarder, "n1", unique("f"));
    const unsigned id = subscribes_through(forwarder, "n1", topic());
    const std::string data(300, 'x');  // long form inside the header's short one
    forwarder.says(encapsulated("n1", publish(no_flags, id, 0, data)));
    forwarder.hears(encapsulated("n1", publish(no_flags, id, 0, data)));
}

TEST_P(S5_5_Forwarder, b_CtrlBitsAboveTheRadiusAreIgnored) {
    Client& forwarder = client();
    connects_through(forwarder, "n1", unique("f"));
    forwarder.says(encapsulated("n1", pingreq(), 0xFD));
    forwarder.hears(encapsulated("n1", pingresp()));
}

TEST_P(S5_5_Forwarder, c_WithoutANodeIdItIsDropped) {
    Client& forwarder = client();
    forwarder.says(encapsulated("", connect(unique("f"))));
    hears_nothing(forwarder);
}

TEST_P(S5_5_Forwarder, c_OneInsideAnotherIsDropped) {
    Client& forwarder = client();
    forwarder.says(encapsulated("n1", encapsulated("n2", connect(unique("f")))));
    hears_nothing(forwarder);
}

TEST_P(S5_5_Forwarder, a_HeaderWithoutAMessageIsDropped) {
    Client& forwarder = client();
    forwarder.says(encapsulated("n1", {}));
    hears_nothing(forwarder);
}

TEST_P(S5_5_Forwarder, a_MalformedMessagesInsideAreDropped) {
    Client& forwarder = client();
    connects_through(forwarder, "n1", unique("f"));
    for (const Octets& inside : {Octets{0x03, 0x16}, Octets{0x00}, Octets{0x02, 0x03},
                                 Octets{0x02, 0x16, 0x00}, Octets{0x01, 0x00, 0x03}}) {
        forwarder.says(encapsulated("n1", inside));
        hears_nothing(forwarder);
    }
    forwarder.says(encapsulated("n1", pingreq()));
    forwarder.hears(encapsulated("n1", pingresp()));
}

TEST_P(S5_5_Forwarder, TheWillPromptsGoThroughAsWell) {
    Client& forwarder = client();
    forwarder.says(encapsulated("n1", connect(unique("f"), clean | with_will)));
    forwarder.hears(encapsulated("n1", willtopicreq()));
    forwarder.says(encapsulated("n1", willtopic("gone")));
    forwarder.hears(encapsulated("n1", willmsgreq()));
    forwarder.says(encapsulated("n1", willmsg("x")));
    forwarder.hears(encapsulated("n1", connack(accepted)));
}

TEST_P(S5_5_Forwarder, SearchgwIsAnsweredThroughIt) {
    Client& forwarder = client();
    forwarder.says(encapsulated("n1", searchgw(1)));
    const Octets answer = forwarder.next();
    ASSERT_EQ(answer.size(), 3u + 2u + 3u) << describe(answer);
    EXPECT_EQ(answer[6], 0x02);
}

}  // namespace
}  // namespace romano::conformance::forwarder_test
