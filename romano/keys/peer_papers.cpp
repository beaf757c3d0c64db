#include "romano/keys/peer_papers.h"

#include <algorithm>
#include <array>
#include <ctime>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"

namespace romano::keys {
namespace {

namespace fs = std::filesystem;

constexpr const char* opening =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
    "xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-SECURITY/20170901/";

constexpr const char* all_domains =
    "<domains><id_range><min>0</min><max>230</max></id_range></domains>\n";

// Packets are sealed whole, which costs the least where many samples share one (RTPS protection);
// nothing is sealed a second time below.
std::string governance() {
    return std::string{opening} +
           "omg_shared_ca_governance.xsd\">\n<domain_access_rules><domain_rule>\n" + all_domains +
           "<allow_unauthenticated_participants>false</allow_unauthenticated_participants>\n"
           "<enable_join_access_control>true</enable_join_access_control>\n"
           "<discovery_protection_kind>ENCRYPT</discovery_protection_kind>\n"
           "<liveliness_protection_kind>SIGN</liveliness_protection_kind>\n"
           "<rtps_protection_kind>ENCRYPT</rtps_protection_kind>\n"
           "<topic_access_rules><topic_rule><topic_expression>*</topic_expression>\n"
           "<enable_discovery_protection>true</enable_discovery_protection>\n"
           "<enable_liveliness_protection>false</enable_liveliness_protection>\n"
           "<enable_read_access_control>true</enable_read_access_control>\n"
           "<enable_write_access_control>true</enable_write_access_control>\n"
           "<metadata_protection_kind>NONE</metadata_protection_kind>\n"
           "<data_protection_kind>NONE</data_protection_kind>\n"
           "</topic_rule></topic_access_rules>\n"
           "</domain_rule></domain_access_rules></dds>\n";
}

std::string xml_date(std::time_t time) {
    std::tm parts{};
    gmtime_r(&time, &parts);
    std::array<char, 32> text{};
    (void)std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
    return text.data();
}

std::string permissions(std::string_view broker, int days) {
    constexpr std::time_t hour = 3600;
    const std::time_t now = std::time(nullptr);
    const std::string topics = "<topics><topic>romano_*</topic></topics>";
    return std::string{opening} + "omg_shared_ca_permissions.xsd\">\n<permissions><grant name=\"" +
           std::string{broker} + "\">\n<subject_name>" + subject_of_broker(broker) +
           "</subject_name>\n<validity><not_before>" + xml_date(now - hour) +
           "</not_before><not_after>" + xml_date(now + days * 24 * hour) +
           "</not_after></validity>\n<allow_rule>\n" + all_domains + "<publish>" + topics +
           "</publish>\n<subscribe>" + topics +
           "</subscribe>\n</allow_rule>\n<default>DENY</default>\n</grant></permissions></dds>\n";
}

constexpr std::array<const char*, 5> papers = {authority_name, broker_certificate_name,
                                               governance_name, permissions_name, revoked_name};

}  // namespace

void write_peer_papers(const Authority& authority, std::string_view broker, const fs::path& folder,
                       int days) {
    write_private_file(folder / authority_name, authority.certificate());
    write_private_file(folder / broker_certificate_name,
                       authority.issue(broker, Holder::broker, days));
    write_private_file(folder / governance_name, authority.sign(governance()));
    write_private_file(folder / permissions_name, authority.sign(permissions(broker, days)));
}

bool has_peer_papers(const fs::path& folder) {
    return std::ranges::all_of(papers, [&](const char* name) { return fs::exists(folder / name); });
}

std::vector<std::string> problems_of_peer_papers(const fs::path& folder) {
    std::vector<std::string> problems;
    for (const char* name : papers) {
        if (fs::exists(folder / name)) continue;
        problems.push_back((folder / name).string() +
                           ": is missing, so that other brokers do not believe this one; `romano "
                           "keys renew FLEET NAME` makes it");
    }
    if (!problems.empty()) return problems;
    const auto read = [&](const char* name) { return read_private_file(folder / name); };
    const std::string own = read(broker_certificate_name);
    const std::string authority = read(authority_name);
    const std::string which = (folder / broker_certificate_name).string();
    (void)read(governance_name);
    (void)read(permissions_name);
    if (const auto flaw = flaw_of(own)) {
        problems.push_back(which + ": " + *flaw);
    } else if (!is_signed_by(own, authority)) {
        problems.push_back(which + ": is of another authority than authority.pem beside it");
    } else if (is_revoked(own, read(revoked_name))) {
        problems.push_back(which +
                           ": is revoked; `romano keys renew FLEET NAME` makes another one");
    }
    return problems;
}

}  // namespace romano::keys
