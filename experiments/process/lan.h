// A LAN of several machines on this one: network namespaces, each with an eth0 on one bridge. Needs
// root.
#pragma once

#include <optional>
#include <string>

namespace romano::experiments {

class Lan {
public:
    /// Hosts 1 to `hosts`, each with 10.60.0.<host>/24 and fd60::<host>/64 of its own.
    explicit Lan(int hosts);
    ~Lan();
    Lan(const Lan&) = delete;
    Lan& operator=(const Lan&) = delete;

    /// Gives each of these hosts an interface `cell0` with one and the same address (and hardware
    /// address, as access points of one network have), into a cell of its own; and makes one more
    /// host, hosts + 1, that is in the first cell with 10.99.0.50.
    void add_cells(int cells);
    static constexpr const char* cell_address = "10.99.0.1";
    static constexpr const char* rover_address = "10.99.0.50";
    /// That host drives into another cell.
    void drive_to(int cell);

    /// Why it cannot be built here; empty when it was.
    [[nodiscard]] const std::string& why_not() const { return why_not_; }

    [[nodiscard]] std::string mac_of(int host) const;
    /// The hardware address that `host` has for an address; empty when none.
    [[nodiscard]] std::string neighbour(int host, const std::string& address) const;
    [[nodiscard]] bool has_address(int host, const std::string& address) const;

    /// The host's cable is pulled, or plugged in again.
    void cut(int host);
    void mend(int host);

    /// While it lives, this thread's new sockets and processes are on that host.
    class On {
    public:
        On(const Lan& lan, int host);
        ~On();
        On(const On&) = delete;
        On& operator=(const On&) = delete;

    private:
        int home_;
    };

private:
    [[nodiscard]] std::string name(int host) const;
    /// `ip` with these words; else why_not() says so.
    bool run(const std::string& words);

    std::string prefix_;
    int hosts_;
    bool has_cells_ = false;
    std::string why_not_;
};

}  // namespace romano::experiments
