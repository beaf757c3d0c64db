#include "overlay/radio/channel.h"

#include <ns3/constant-position-mobility-model.h>
#include <ns3/icmpv6-l4-protocol.h>
#include <ns3/internet-stack-helper.h>
#include <ns3/ipv6-interface.h>
#include <ns3/ipv6-l3-protocol.h>
#include <ns3/lr-wpan-csmaca.h>
#include <ns3/lr-wpan-error-model.h>
#include <ns3/lr-wpan-net-device.h>
#include <ns3/lr-wpan-spectrum-value-helper.h>
#include <ns3/ndisc-cache.h>
#include <ns3/node.h>
#include <ns3/propagation-loss-model.h>
#include <ns3/rng-seed-manager.h>
#include <ns3/simulator.h>
#include <ns3/single-model-spectrum-channel.h>
#include <ns3/sixlowpan-net-device.h>
#include <ns3/socket.h>
#include <ns3/udp-socket-factory.h>

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "overlay/radio/watched_scheduler.h"

namespace romano::lowpan {
namespace {

constexpr std::uint16_t port = 1883;
constexpr std::int64_t streams_per_device = 10;

/// The owner's propagation in place of ns-3's.
class OwnersLoss final : public ns3::PropagationLossModel {
public:
    using Dbm = std::function<double(const ns3::MobilityModel* from, const ns3::MobilityModel* to)>;
    explicit OwnersLoss(Dbm dbm) : dbm_(std::move(dbm)) {}

private:
    double DoCalcRxPower(double, ns3::Ptr<ns3::MobilityModel> from,
                         ns3::Ptr<ns3::MobilityModel> to) const override {
        return dbm_(ns3::PeekPointer(from), ns3::PeekPointer(to));
    }
    std::int64_t DoAssignStreams(std::int64_t) override { return 0; }

    Dbm dbm_;
};

}  // namespace

struct Channel::Ns3 {
    struct Radio {
        Device device;
        ns3::Ptr<ns3::Node> node;
        ns3::Ptr<ns3::LrWpanNetDevice> mac;
        ns3::Ptr<ns3::NdiscCache> neighbours;
        ns3::Ipv6Address address;
        ns3::Ptr<ns3::Socket> socket;
        std::size_t frames_waiting = 0;
        Air sent;
        std::map<ns3::Mac16Address, std::uint8_t> last_sequence;
    };

    explicit Ns3(Owner whose) : owner(std::move(whose)) {}
    ~Ns3() {
        radios.clear();
        media.clear();
        ns3::Simulator::Destroy();
    }

    void add_medium(unsigned number);
    void add_radio(const Device& device, const CellPlan& cell, double transmit_dbm,
                   double noise_dbm);
    void make_known(Radio& a, Radio& b);
    void on_confirm(Radio& radio, ns3::LrWpanMcpsDataConfirmStatus status);
    void on_indication(Radio& radio, const ns3::McpsDataIndicationParams& params,
                       ns3::Ptr<ns3::Packet> frame);
    void on_datagram(Radio& radio, ns3::Ptr<ns3::Socket> socket);
    void send(Radio& radio, ns3::Ipv6Address to, const std::vector<std::uint8_t>& datagram);

    Owner owner;
    Counters counters;
    std::map<unsigned, ns3::Ptr<ns3::SingleModelSpectrumChannel>> media;
    std::map<Device, Radio> radios;
    std::map<const ns3::MobilityModel*, Device> placed;
    std::map<std::pair<std::size_t, ns3::Ipv6Address>, Device> addressed;  // cells have the same
};

void Channel::Ns3::add_medium(unsigned number) {
    auto& medium = media[number];
    if (medium) return;
    medium = ns3::CreateObject<ns3::SingleModelSpectrumChannel>();
    medium->AddPropagationLossModel(
        ns3::Create<OwnersLoss>([this](const auto* from, const auto* to) {
            return owner.dbm(placed.at(from), placed.at(to));
        }));
}

void Channel::Ns3::add_radio(const Device& device, const CellPlan& cell, double transmit_dbm,
                             double noise_dbm) {
    Radio& radio = radios[device];
    radio.device = device;
    radio.node = ns3::CreateObject<ns3::Node>();
    radio.mac = ns3::CreateObject<ns3::LrWpanNetDevice>();
    const auto place = ns3::CreateObject<ns3::ConstantPositionMobilityModel>();
    placed.emplace(ns3::PeekPointer(place), device);
    radio.node->AggregateObject(place);
    radio.mac->SetChannel(media.at(cell.channel));
    radio.node->AddDevice(radio.mac);
    const auto phy = radio.mac->GetPhy();
    phy->SetMobility(place);
    phy->SetErrorModel(ns3::CreateObject<ns3::LrWpanErrorModel>());
    ns3::LrWpanPhyPibAttributes pib{};
    pib.phyCurrentChannel = static_cast<std::uint8_t>(cell.channel);
    phy->PlmeSetAttributeRequest(ns3::phyCurrentChannel, &pib);  // makes both of the following anew
    ns3::LrWpanSpectrumValueHelper spectrum;
    phy->SetTxPowerSpectralDensity(
        spectrum.CreateTxPowerSpectralDensity(transmit_dbm, cell.channel));
    const auto noise = spectrum.CreateNoisePowerSpectralDensity(cell.channel);
    const double thermal =
        ns3::LrWpanSpectrumValueHelper::TotalAvgPower(noise, cell.channel);  // in watts
    phy->SetNoisePowerSpectralDensity(
        ns3::Create<ns3::SpectrumValue>(*noise * (std::pow(10.0, noise_dbm / 10 - 3) / thermal)));

    const auto mac = radio.mac->GetMac();
    mac->SetPanId(static_cast<std::uint16_t>(device.cell + 1));
    const auto number = static_cast<std::uint16_t>(device.number + 1);
    std::uint8_t octets[2] = {static_cast<std::uint8_t>(number >> 8U),
                              static_cast<std::uint8_t>(number & 0xFFU)};
    ns3::Mac16Address short_address;
    short_address.CopyFrom(octets);
    mac->SetShortAddress(short_address);
    mac->SetMcpsDataConfirmCallback(ns3::Callback<void, ns3::McpsDataConfirmParams>(
        [this, &radio](ns3::McpsDataConfirmParams done) { on_confirm(radio, done.m_status); }));
    mac->SetMcpsDataIndicationCallback(
        ns3::Callback<void, ns3::McpsDataIndicationParams, ns3::Ptr<ns3::Packet>>(
            [this, &radio](ns3::McpsDataIndicationParams params, ns3::Ptr<ns3::Packet> frame) {
                on_indication(radio, params, frame);
            }));
    mac->TraceConnectWithoutContext(
        "MacTxEnqueue", ns3::Callback<void, ns3::Ptr<const ns3::Packet>>(
                            [&radio](ns3::Ptr<const ns3::Packet>) { ++radio.frames_waiting; }));
    phy->TraceConnectWithoutContext("PhyTxBegin",
                                    ns3::Callback<void, ns3::Ptr<const ns3::Packet>>(
                                        [this, &radio](ns3::Ptr<const ns3::Packet> frame) {
                                            ++counters.frames;
                                            counters.air_octets += frame->GetSize();
                                            ++radio.sent.frames;
                                            radio.sent.octets += frame->GetSize();
                                        }));

    const auto lowpan = ns3::CreateObject<ns3::SixLowPanNetDevice>();
    radio.node->AddDevice(lowpan);
    lowpan->SetNetDevice(radio.mac);
    ns3::InternetStackHelper stack;
    stack.SetIpv4StackInstall(false);
    stack.SetIpv6NsRsJitter(false);
    stack.Install(radio.node);
    const auto icmp = radio.node->GetObject<ns3::Icmpv6L4Protocol>();
    icmp->SetAttribute("DAD", ns3::BooleanValue(false));
    const auto ip = radio.node->GetObject<ns3::Ipv6L3Protocol>();
    const std::uint32_t interface = ip->AddInterface(lowpan);
    ip->SetForwarding(interface, true);  // a router solicits no routers
    ip->SetUp(interface);
    radio.address = ip->GetInterface(interface)->GetLinkLocalAddress().GetAddress();
    addressed.emplace(std::pair{device.cell, radio.address}, device);
    radio.neighbours = ip->GetInterface(interface)->GetNdiscCache();

    radio.socket = ns3::Socket::CreateSocket(radio.node, ns3::UdpSocketFactory::GetTypeId());
    radio.socket->Bind(ns3::Inet6SocketAddress(ns3::Ipv6Address::GetAny(), port));
    radio.socket->BindToNetDevice(lowpan);
    radio.socket->SetRecvCallback(ns3::Callback<void, ns3::Ptr<ns3::Socket>>(
        [this, &radio](ns3::Ptr<ns3::Socket> socket) { on_datagram(radio, socket); }));

    // What ns-3 would draw from the process's own count of streams differs in a second run.
    const auto stream = static_cast<std::int64_t>(radios.size()) * streams_per_device;
    radio.mac->AssignStreams(stream);
    lowpan->AssignStreams(stream + 3);
    icmp->AssignStreams(stream + 5);
}

/// For ever: neighbour discovery over this radio loses the first datagrams.
void Channel::Ns3::make_known(Radio& a, Radio& b) {
    const auto know = [](Radio& who, const Radio& whom) {
        auto* entry = who.neighbours->Add(whom.address);
        entry->SetMacAddress(whom.mac->GetAddress());
        entry->MarkPermanent();
    };
    know(a, b);
    know(b, a);
}

void Channel::Ns3::on_confirm(Radio& radio, ns3::LrWpanMcpsDataConfirmStatus status) {
    if (status != ns3::IEEE_802_15_4_SUCCESS) ++counters.given_up;
    if (radio.frames_waiting > 0 && --radio.frames_waiting == 0) owner.ready(radio.device);
}

/// ns-3's MAC passes on what was repeated because its acknowledgement was lost.
void Channel::Ns3::on_indication(Radio& radio, const ns3::McpsDataIndicationParams& params,
                                 ns3::Ptr<ns3::Packet> frame) {
    const auto [last, is_first] = radio.last_sequence.emplace(params.m_srcAddr, params.m_dsn);
    if (!is_first && std::exchange(last->second, params.m_dsn) == params.m_dsn) {
        ++counters.duplicates;
        return;
    }
    radio.mac->McpsDataIndication(params, frame);
}

void Channel::Ns3::on_datagram(Radio& radio, ns3::Ptr<ns3::Socket> socket) {
    ns3::Address from;
    while (const auto packet = socket->RecvFrom(from)) {
        std::vector<std::uint8_t> octets(packet->GetSize());
        packet->CopyData(octets.data(), packet->GetSize());
        const auto sender = addressed.find(
            {radio.device.cell, ns3::Inet6SocketAddress::ConvertFrom(from).GetIpv6()});
        if (sender != addressed.end()) owner.received(radio.device, sender->second, octets);
    }
}

Channel::Channel(const std::vector<CellPlan>& cells, double transmit_dbm, double noise_dbm,
                 std::uint64_t seed, Owner owner) {
    ns3::ObjectFactory scheduler;
    scheduler.SetTypeId(WatchedScheduler::GetTypeId());
    ns3::Simulator::SetScheduler(scheduler);
    ns3::RngSeedManager::SetSeed(static_cast<std::uint32_t>(seed >> 32U) % 0x7FFFFFFFU + 1);
    ns3::RngSeedManager::SetRun(seed & 0xFFFFFFFFU);
    ns3_ = std::make_unique<Ns3>(std::move(owner));
    for (const CellPlan& cell : cells) ns3_->add_medium(cell.channel);
    for (std::size_t i = 0; i < cells.size(); ++i) {
        for (std::size_t number = 0; number <= cells[i].robots; ++number) {
            ns3_->add_radio({i, number}, cells[i], transmit_dbm, noise_dbm);
        }
    }
    run_until(0);  // nodes and devices begin
    for (std::size_t i = 0; i < cells.size(); ++i) {
        for (std::size_t number = 1; number <= cells[i].robots; ++number) {
            const std::size_t others = cells[i].all_talk ? number : 1;
            for (std::size_t other = 0; other < others; ++other) {
                ns3_->make_known(ns3_->radios.at({i, other}), ns3_->radios.at({i, number}));
            }
        }
    }
}

Channel::~Channel() = default;

void Channel::Ns3::send(Radio& radio, ns3::Ipv6Address to,
                        const std::vector<std::uint8_t>& datagram) {
    const auto packet =
        ns3::Create<ns3::Packet>(datagram.data(), static_cast<std::uint32_t>(datagram.size()));
    radio.socket->SendTo(packet, 0, ns3::Inet6SocketAddress(to, port));
    if (radio.frames_waiting == 0) owner.ready(radio.device);  // longer than 6LoWPAN takes
}

void Channel::send(std::int64_t now_ns, Device from, Device to,
                   const std::vector<std::uint8_t>& datagram) {
    run_until(now_ns);
    ns3_->send(ns3_->radios.at(from), ns3_->radios.at(to).address, datagram);
}

void Channel::broadcast(std::int64_t now_ns, Device from,
                        const std::vector<std::uint8_t>& datagram) {
    run_until(now_ns);
    ns3_->send(ns3_->radios.at(from), ns3::Ipv6Address::GetAllNodesMulticast(), datagram);
}

void Channel::run_until(std::int64_t now_ns) {
    ns3::Simulator::Stop(ns3::NanoSeconds(now_ns) - ns3::Simulator::Now());
    ns3::Simulator::Run();
}

std::int64_t Channel::next_wakeup_ns() const {
    return WatchedScheduler::next_ns();
}

const Counters& Channel::counters() const {
    return ns3_->counters;
}

const Air& Channel::sent_by(Device device) const {
    return ns3_->radios.at(device).sent;
}

std::int64_t air_time_ns(const Air& air) {
    constexpr std::uint64_t octets_before_a_frame = 6;
    constexpr std::uint64_t ns_an_octet = 32'000;
    return static_cast<std::int64_t>((air.octets + octets_before_a_frame * air.frames) *
                                     ns_an_octet);
}

}  // namespace romano::lowpan
