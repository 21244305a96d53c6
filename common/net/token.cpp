#include "common/net/token.hpp"

#include <fcntl.h>
#include <openssl/rand.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "common/net/credentials.hpp"
#include "common/net/socket.hpp"
#include "common/util/error.hpp"

namespace terravox::net {
namespace {

constexpr std::size_t kMostFile_bytes = 4096;

std::string read_private_file(const std::filesystem::path& path) {
    const auto failed = [&](const std::string& why) { return Error("read the token file " + path.string() + ": " + why); };
    const Socket file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file) throw failed(std::strerror(errno));
    struct stat facts {};
    if (::fstat(file.fd(), &facts) != 0) throw failed(std::strerror(errno));
    if (S_ISDIR(facts.st_mode)) throw failed("it is a folder");
    if (S_ISREG(facts.st_mode) && (facts.st_mode & 077) != 0)
        throw failed("others may read or change it; allowed: only its owner (chmod 600)");
    std::string text(kMostFile_bytes + 1, '\0');
    std::size_t size_bytes = 0;
    while (size_bytes < text.size()) {
        const ssize_t got = ::read(file.fd(), text.data() + size_bytes, text.size() - size_bytes);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw failed(std::strerror(errno));
        if (got == 0) break;
        size_bytes += static_cast<std::size_t>(got);
    }
    if (size_bytes > kMostFile_bytes) throw failed("it is longer than " + std::to_string(kMostFile_bytes) + " bytes");
    text.resize(size_bytes);
    return text;
}

std::string checked(std::string token, const std::string& where) {
    while (!token.empty() && std::strchr(" \t\r\n", token.back()) != nullptr) token.pop_back();
    if (token.size() < kLeastToken)
        throw Error(where + ": the token has " + std::to_string(token.size()) + " characters; allowed: at least " +
                    std::to_string(kLeastToken));
    for (const char c : token)
        if (c < ' ' || c == 0x7f) throw Error(where + ": the token has a control character; allowed: one line of text");
    return token;
}

}  // namespace

std::string new_token() {
    // 32 letters, so that no remainder favours one; none of them is easily taken for another.
    static constexpr std::string_view kLetters = "abcdefghjkmnpqrstuvwxyz123456789";
    static_assert(kLetters.size() == 32);
    std::array<unsigned char, 32> bytes{};
    if (::RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) throw Error("make a token: the system's random generator failed");
    std::string out;
    for (const unsigned char byte : bytes) out += kLetters[byte % kLetters.size()];
    return out;
}

std::string find_token(const std::filesystem::path& file) {
    if (!file.empty()) return checked(read_private_file(file), "read the token file " + file.string());
    const char* variable = std::getenv("TERRAVOX_TOKEN");
    if (variable == nullptr || *variable == '\0') return {};
    return checked(variable, "read the environment variable TERRAVOX_TOKEN");
}

}  // namespace terravox::net
