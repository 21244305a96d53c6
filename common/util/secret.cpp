#include "common/util/secret.hpp"

#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <set>
#include <system_error>

#include "common/util/error.hpp"

namespace terravox::util {
namespace {

constexpr std::size_t kMaxFile_bytes = 4096;
constexpr std::size_t kMinToken = 32;
constexpr std::size_t kMaxToken = 512;
constexpr std::size_t kMinDifferent = 10;
constexpr std::string_view kMarks = "-._~+/=";

std::string read_variable(const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr ? value : "";
}

// When both secrets had one name, each of them was sent to where the other one belongs.
void refuse_old_name() {
    if (read_variable("TERRAVOX_TOKEN").empty())
        return;
    throw UsageError(
        "read the environment variable TERRAVOX_TOKEN: it was one name for two secrets; allowed: "
        "{} for a coordinator and its workers, {} for a voxel server and its clients",
        kFarmTokenVariable, kServerTokenVariable);
}

// A file that systemd passes to a service (LoadCredential=): in a folder that only this service can
// enter. Newer versions let the group read the files, and name the service's user in an access
// control list.
bool is_credential_of_service(const std::filesystem::path& path) {
    const std::string folder = read_variable("CREDENTIALS_DIRECTORY");
    return !folder.empty() && path.lexically_normal().parent_path() ==
                                  std::filesystem::path(folder).lexically_normal();
}

std::string read_private_file(const std::filesystem::path& path, const std::string& attempt) {
    const auto failed = [&](const std::string& why) { return Error(attempt + ": " + why); };
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                               &std::fclose);
    if (!file)
        throw failed(std::strerror(errno));
    struct stat facts{};
    if (::fstat(::fileno(file.get()), &facts) != 0)
        throw failed(std::strerror(errno));
    if (S_ISDIR(facts.st_mode))
        throw failed("it is a folder");
    const mode_t of_others = is_credential_of_service(path) ? 037 : 077;
    if (S_ISREG(facts.st_mode) && (facts.st_mode & of_others) != 0)
        throw failed("others may read or change it; allowed: only its owner (chmod 600)");
    std::string text(kMaxFile_bytes + 1, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file.get()));
    if (std::ferror(file.get()) != 0)
        throw failed(std::strerror(errno));
    if (text.size() > kMaxFile_bytes)
        throw failed("it is longer than " + std::to_string(kMaxFile_bytes) + " bytes");
    return text;
}

/// @return what is wrong with a token; empty: nothing
std::string describe_fault(std::string_view token) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    const auto is_mark = [](char c) { return kMarks.find(c) != std::string_view::npos; };
    if (token.size() < kMinToken || token.size() > kMaxToken)
        return std::to_string(token.size()) + " characters";
    if (!std::all_of(token.begin(), token.end(),
                     [&](char c) { return is_letter(c) || is_digit(c) || is_mark(c); }))
        return "a character that is none of a token";
    if (const std::size_t different = std::set(token.begin(), token.end()).size();
        different < kMinDifferent)
        return std::to_string(different) + " different characters";
    if (std::none_of(token.begin(), token.end(), is_digit))
        return "no digit";
    if (std::none_of(token.begin(), token.end(), is_letter))
        return "no letter";
    return {};
}

}  // namespace

std::string make_token() {
    // 32 letters, so that no remainder favours one; none of them is easily taken for another.
    static constexpr std::string_view kLetters = "abcdefghjkmnpqrstuvwxyz123456789";
    static_assert(kLetters.size() == 32);
    std::string out;
    do {
        std::array<unsigned char, 32> bytes{};
        if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
            throw Error("make a token: the system has no random numbers");
        out.clear();
        for (const unsigned char byte : bytes)
            out += kLetters[byte % kLetters.size()];
    } while (!describe_fault(out).empty());  // one of 40,000 has no digit
    return out;
}

void check_token(std::string_view token, const std::string& attempt) {
    const std::string fault = describe_fault(token);
    if (fault.empty())
        return;
    throw UsageError(
        "{}: the token has {}; allowed: {} to {} letters, digits and {}, at least {} of them "
        "different, with both letters and digits; `terravox farm token` makes one",
        attempt, fault, kMinToken, kMaxToken, kMarks, kMinDifferent);
}

std::filesystem::path find_credential(const std::string& name) {
    const std::string folder = read_variable("CREDENTIALS_DIRECTORY");
    if (folder.empty())
        return {};
    std::filesystem::path file = std::filesystem::path(folder) / name;
    std::error_code unknown;
    // One that cannot be looked at is there: reading it reports why.
    const bool is_absent =
        std::filesystem::status(file, unknown).type() == std::filesystem::file_type::not_found;
    return is_absent ? std::filesystem::path() : file;
}

std::string find_token(const std::filesystem::path& file, const char* variable) {
    refuse_old_name();
    const std::string attempt = file.empty()
                                    ? std::string("read the environment variable ") + variable
                                    : "read the token file " + file.string();
    std::string out = file.empty() ? read_variable(variable) : read_private_file(file, attempt);
    out.erase(out.find_last_not_of(" \t\r\n") + 1);
    if (!out.empty() || !file.empty())
        check_token(out, attempt);
    return out;
}

}  // namespace terravox::util
