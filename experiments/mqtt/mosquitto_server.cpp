#include "experiments/mqtt/mosquitto_server.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "experiments/process/program.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr auto starts_within = 10s;

void run(const std::string& program, const std::vector<std::string>& arguments,
         const fs::path& folder) {
    if (!run_program(program, arguments, folder).ok()) {
        throw std::runtime_error("`" + program + " " + arguments.front() +
                                 "` failed; are mosquitto and openssl installed?");
    }
}

std::string program() {
    for (const char* path : {"/usr/sbin/mosquitto", "/usr/bin/mosquitto"}) {
        if (fs::exists(path)) return path;
    }
    throw std::runtime_error("there is no mosquitto; install the package mosquitto");
}

bool listens(const std::string& address, std::uint16_t port) {
    boost::asio::io_context io;
    boost::asio::ip::tcp::socket socket(io);
    boost::system::error_code error;
    socket.connect({boost::asio::ip::make_address(address), port}, error);
    return !error;
}

}  // namespace

MosquittoServer::MosquittoServer(const fs::path& folder, std::vector<std::string> addresses,
                                 std::uint16_t port, bool tls)
    : folder_(fs::absolute(folder)), addresses_(std::move(addresses)), port_(port), tls_(tls) {
    fs::create_directories(folder_);
    if (tls_) make_certificates();
    write_files();
    start();
}

void MosquittoServer::make_certificates() const {
    std::string names;
    for (const std::string& address : addresses_) {
        names += (names.empty() ? "IP:" : ",IP:") + address;
    }
    const auto request = [this](const std::string& name, std::vector<std::string> arguments) {
        const std::vector<std::string> key = {
            "-keyout", name + ".key", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
            "-nodes"};
        arguments.insert(arguments.begin(), "req");
        arguments.insert(arguments.end(), key.begin(), key.end());
        run("openssl", arguments, folder_);
    };
    request("ca", {"-x509", "-days", "30", "-subj", "/CN=ROMANO experiment", "-out", "ca.crt"});
    request("server", {"-new", "-subj", "/CN=mosquitto", "-addext", "subjectAltName=" + names,
                       "-out", "server.csr"});
    run("openssl",
        {"x509", "-req", "-days", "30", "-in", "server.csr", "-CA", "ca.crt", "-CAkey", "ca.key",
         "-CAcreateserial", "-copy_extensions", "copy", "-out", "server.crt"},
        folder_);
}

void MosquittoServer::write_files() const {
    run("mosquitto_passwd", {"-b", "-c", "users", username, password}, folder_);
    std::ofstream(password_file()) << password << '\n';
    std::ofstream config(folder_ / "mosquitto.conf");
    config << "user root\nallow_anonymous false\npersistence false\nset_tcp_nodelay true\n"
           << "max_queued_messages 100000\nlog_dest stderr\n"
           << "password_file " << (folder_ / "users").string() << '\n';
    for (const std::string& address : addresses_) {
        config << "listener " << port_ << ' ' << address << '\n';
        if (!tls_) continue;
        config << "cafile " << ca_file() << "\ncertfile " << (folder_ / "server.crt").string()
               << "\nkeyfile " << (folder_ / "server.key").string() << '\n';
    }
    if (!config) throw std::runtime_error("cannot write into `" + folder_.string() + "`");
}

void MosquittoServer::start() {
    process_ = std::make_unique<BrokerProcess>(
        "mosquitto", program(),
        std::vector<std::string>{"-c", (folder_ / "mosquitto.conf").string()},
        folder_ / "mosquitto.txt");
    const auto deadline = std::chrono::steady_clock::now() + starts_within;
    for (const std::string& address : addresses_) {
        while (!listens(address, port_)) {
            if (process_->has_ended() || std::chrono::steady_clock::now() > deadline) {
                throw std::runtime_error("mosquitto does not listen at " + address + ": see `" +
                                         (folder_ / "mosquitto.txt").string() + "`");
            }
            std::this_thread::sleep_for(20ms);
        }
    }
}

std::string MosquittoServer::url(const std::string& address) const {
    const bool v6 = address.find(':') != std::string::npos;
    return std::string(tls_ ? "mqtts://" : "mqtt://") + (v6 ? "[" + address + "]" : address) + ":" +
           std::to_string(port_);
}

}  // namespace romano::experiments
