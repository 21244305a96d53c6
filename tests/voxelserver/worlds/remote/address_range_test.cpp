#include "voxelserver/worlds/remote/address_range.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/un.h>

#include <sstream>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

struct Number {
    explicit Number(const std::string& text) {
        const bool six = text.find(':') != std::string::npos;
        storage.ss_family = six ? AF_INET6 : AF_INET;
        void* to = six ? static_cast<void*>(&reinterpret_cast<sockaddr_in6&>(storage).sin6_addr)
                       : &reinterpret_cast<sockaddr_in&>(storage).sin_addr;
        REQUIRE(inet_pton(storage.ss_family, text.c_str(), to) == 1);
    }
    [[nodiscard]] const sockaddr& get() const { return reinterpret_cast<const sockaddr&>(storage); }
    sockaddr_storage storage{};
};

}  // namespace

TEST_CASE("an address belongs to the range that its number lies in", "[raytracer][world][http]") {
    struct Case {
        remote::AddressRange range;
        const char* numbers;
    };
    for (const Case& c : {
             Case{remote::AddressRange::kPublic,
                  "1.1.1.1 8.8.8.8 9.255.255.255 11.0.0.0 100.63.255.255 100.128.0.0 "
                  "126.255.255.255 128.0.0.0 169.253.255.255 172.15.255.255 172.32.0.0 "
                  "192.167.255.255 192.169.0.0 198.17.255.255 198.20.0.0 223.255.255.255 "
                  "2001:4860:4860::8888 2001:200:: 2600::1 3ffe:ffff::1"},
             Case{remote::AddressRange::kPrivate,
                  "10.0.0.0 10.255.255.255 172.16.0.0 172.31.255.255 192.168.0.0 192.168.255.255 "
                  "169.254.169.254 100.64.0.1 100.127.255.255 fc00::1 fdff:ffff::1 fe80::1 "
                  "febf::1"},
             Case{remote::AddressRange::kLoopback, "127.0.0.1 127.0.1.1 127.255.255.255 ::1"},
             Case{remote::AddressRange::kNoMachine,
                  "0.0.0.0 0.1.2.3 192.0.0.1 192.0.2.1 192.88.99.1 198.18.0.1 198.19.255.255 "
                  "198.51.100.1 203.0.113.1 224.0.0.1 239.255.255.255 240.0.0.1 255.255.255.255 "
                  ":: ::2 ::ffff:127.0.0.1 ::ffff:8.8.8.8 ::127.0.0.1 64:ff9b::7f00:1 2001::1 "
                  "2001:db8::1 2002:7f00:1:: 3fff::1 fec0::1 ff02::1 4000::1 1fff::1"},
         }) {
        std::istringstream numbers(c.numbers);
        for (std::string number; numbers >> number;) {
            INFO(number);
            CHECK(remote::range_of(Number(number).get()) == c.range);
        }
    }
    CHECK(remote::text_of(Number("127.0.0.1").get()) == "127.0.0.1");
    CHECK(remote::text_of(Number("fe80::1").get()) == "fe80::1");
    sockaddr local{};
    local.sa_family = AF_UNIX;
    CHECK(remote::range_of(local) == remote::AddressRange::kNoMachine);
}
