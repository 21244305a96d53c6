#include "raytracer/farm/net/token.hpp"

#include <openssl/rand.h>

#include <array>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/secret.hpp"
#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/token_strength.hpp"

namespace terravox::net {

std::string new_token() {
    // 32 letters, so that no remainder favours one; none of them is easily taken for another.
    static constexpr std::string_view kLetters = "abcdefghjkmnpqrstuvwxyz123456789";
    static_assert(kLetters.size() == 32);
    std::array<unsigned char, 32> bytes{};
    if (::RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
        throw util::Error("make a token: the system's random generator failed");
    std::string out;
    for (const unsigned char byte : bytes)
        out += kLetters[byte % kLetters.size()];
    return out;
}

std::string find_token(const std::filesystem::path& file) {
    const auto [token, attempt] = util::find_secret(file, util::kFarmTokenVariable);
    if (token.empty() && file.empty())
        return {};
    for (const char c : token)
        if (c < ' ' || c == 0x7f)
            throw util::Error(attempt +
                              ": the token has a control character; allowed: one line of text");
    const std::string weakness = weakness_of(token);
    if (!weakness.empty())
        throw util::UsageError(attempt + ": " + weakness);
    return token;
}

}  // namespace terravox::net
