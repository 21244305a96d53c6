#include "voxelserver/serve/sockets/address.hpp"

#include <charconv>

#include "common/util/error.hpp"

namespace terravox::sockets {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
    throw util::UsageError("read the address '" + text + "': " + why +
                           "; allowed: HOST:PORT, :PORT, [IPV6]:PORT, port 0 to 65535");
}

}  // namespace

Address Address::parse(const std::string& text, std::uint16_t default_port) {
    Address out{.host = {}, .port = default_port};
    std::string port;
    bool has_port = false;
    if (text.starts_with('[')) {
        const auto end = text.find(']');
        if (end == std::string::npos)
            refuse(text, "no ']' after '['");
        out.host = text.substr(1, end - 1);
        if (out.host.find(':') == std::string::npos)
            refuse(text, "no IPv6 address between '[' and ']'");
        const std::string rest = text.substr(end + 1);
        if (!rest.empty() && rest.front() != ':')
            refuse(text, "something after ']' that is no port");
        has_port = !rest.empty();
        if (has_port)
            port = rest.substr(1);
    } else if (const auto colon = text.find(':'); colon != std::string::npos) {
        // Ambiguous without brackets: the port of "fe80::1:80" cannot be determined.
        if (text.find(':', colon + 1) != std::string::npos)
            refuse(text, "an IPv6 address stands in brackets");
        out.host = text.substr(0, colon);
        has_port = true;
        port = text.substr(colon + 1);
    } else {
        out.host = text;
        if (text.empty())
            refuse(text, "it is empty");
    }
    for (const char c : out.host)
        if (c <= ' ' || c == '/' || c == '@' || c == 0x7f || static_cast<unsigned char>(c) >= 0x80)
            refuse(text, "a host has no such character");
    if (has_port) {
        unsigned value = 0;
        const auto [end, failed] = std::from_chars(port.data(), port.data() + port.size(), value);
        if (failed != std::errc() || end != port.data() + port.size() || value > 65535)
            refuse(text, "'" + port + "' is no port");
        out.port = static_cast<std::uint16_t>(value);
    } else if (default_port == 0) {
        refuse(text, "no port");
    }
    return out;
}

std::string Address::text() const {
    return (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" +
           std::to_string(port);
}

}  // namespace terravox::sockets
