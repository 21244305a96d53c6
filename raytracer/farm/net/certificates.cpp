#include "raytracer/farm/net/certificates.hpp"

#include <fcntl.h>
#include <grpc/grpc_security_constants.h>
#include <openssl/rand.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "raytracer/farm/net/credentials.hpp"
#include "raytracer/farm/net/openssl.hpp"
#include "voxelserver/serve/sockets/socket.hpp"

namespace terravox::net {
namespace {

void free_names(GENERAL_NAMES* names) noexcept {
    GENERAL_NAMES_free(names);
}

/// @return false if there is no such list, since nothing is revoked then
bool is_revoked(X509* certificate, const std::filesystem::path& ca) {
    const std::filesystem::path path = find_revocation_list(ca);
    std::error_code unknown;
    if (!std::filesystem::exists(path, unknown) && !unknown)
        return false;
    const auto failed = [&](const std::string& why) {
        return util::Error("read the revoked certificates " + path.string() + ": " + why);
    };
    const auto authority = parse_certificates(text_of_pem(ca, "CA certificate"));
    const CrlPtr list = parse_crl(text_of_pem(path, "list of revoked certificates"));
    if (!list)
        throw failed("it is no PEM of an X.509 CRL");
    if (authority.empty() ||
        X509_CRL_verify(list.get(), X509_get0_pubkey(authority.front().get())) != 1) {
        ERR_clear_error();
        throw failed("the CA " + ca.string() + " has not signed it");
    }
    X509_REVOKED* entry = nullptr;
    return X509_CRL_get0_by_cert(list.get(), &entry, certificate) == 1;
}

std::string read_common_name(X509* certificate) {
    std::array<char, 256> text{};
    const int size = X509_NAME_get_text_by_NID(X509_get_subject_name(certificate), NID_commonName,
                                               text.data(), static_cast<int>(text.size()));
    return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : std::string();
}

}  // namespace

std::string find_role(X509* certificate) {
    const std::unique_ptr<GENERAL_NAMES, FreeBy<free_names>> names(static_cast<GENERAL_NAMES*>(
        X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr)));
    if (!names)
        return {};
    for (int i = 0; i < sk_GENERAL_NAME_num(names.get()); ++i) {
        const GENERAL_NAME* name = sk_GENERAL_NAME_value(names.get(), i);
        if (name->type != GEN_URI)
            continue;
        const ASN1_STRING* uri = name->d.uniformResourceIdentifier;
        const std::string_view text(reinterpret_cast<const char*>(ASN1_STRING_get0_data(uri)),
                                    static_cast<std::size_t>(ASN1_STRING_length(uri)));
        for (const std::string_view role : {kWorkerRole, kCoordinatorRole})
            if (text.starts_with(kRoleUri) && text.substr(kRoleUri.size()) == role)
                return std::string(role);
    }
    return {};
}

std::filesystem::path find_revocation_list(const std::filesystem::path& ca) {
    return std::filesystem::path(ca).replace_extension(".crl");
}

Certified certified_peer(const grpc::AuthContext& context, const std::filesystem::path& ca) {
    const auto shown = context.FindPropertyValues(GRPC_X509_PEM_CERT_PROPERTY_NAME);
    const auto chain = shown.empty()
                           ? std::vector<CertificatePtr>()
                           : parse_certificates({shown.front().data(), shown.front().size()});
    if (chain.empty())
        throw RefusedError("it showed no certificate");
    X509* certificate = chain.front().get();
    if (X509_check_host(certificate, kFarmName.data(), kFarmName.size(),
                        X509_CHECK_FLAG_NEVER_CHECK_SUBJECT, nullptr) != 1)
        throw RefusedError("its certificate does not carry the name " + std::string(kFarmName));
    if (is_revoked(certificate, ca))
        throw RefusedError("its certificate is revoked");
    Certified out{find_role(certificate),
                  read_common_name(certificate),
                  {shown.front().data(), shown.front().size()}};
    if (out.role.empty())
        throw RefusedError(
            "its certificate names no role; terravox farm certs makes certificates with a role");
    return out;
}

RevocationWatch::RevocationWatch(std::string certificate, std::filesystem::path ca)
    : m_certificate(std::move(certificate)),
      m_ca(std::move(ca)),
      m_list(find_revocation_list(m_ca)) {}

RevocationWatch::Stamp RevocationWatch::make_stamp(const std::filesystem::path& file) noexcept {
    struct stat found{};
    if (::stat(file.c_str(), &found) != 0)
        return std::nullopt;
    const auto ns = [](const timespec& t) {
        return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
    };
    return {{static_cast<std::int64_t>(found.st_dev), static_cast<std::int64_t>(found.st_ino),
             static_cast<std::int64_t>(found.st_size), ns(found.st_mtim), ns(found.st_ctim)}};
}

bool RevocationWatch::is_revoked() {
    const std::lock_guard lock(m_mutex);
    // The stamp is taken first: a change while the list is read is noticed at the next check.
    const Stamp now = make_stamp(m_list);
    if (m_revoked || !now || now == m_read)
        return m_revoked;
    try {
        const auto chain = parse_certificates(m_certificate);
        m_revoked = !chain.empty() && net::is_revoked(chain.front().get(), m_ca);
        m_read = now;
    } catch (const std::exception& e) {
        if (m_reported != now)
            util::log_warn("{}; links that are there go on", e.what());
        m_reported = now;
    }
    return m_revoked;
}

namespace {

namespace fs = std::filesystem;

constexpr long kDay_s = 86'400;
constexpr long kClockTolerance_s = kDay_s;  ///< tolerance for clocks of a farm's machines
constexpr mode_t kPrivate = 0600;
constexpr mode_t kPublic = 0644;

/// Files that appear together or, as far as possible, not at all.
class NewFiles {
public:
    ~NewFiles() {
        std::error_code ignored;
        for (const auto& path : m_made)
            fs::remove(path, ignored);
    }
    void write(const fs::path& path, const std::string& text, mode_t mode) {
        const auto failed = [&](int code) {
            return util::Error("write " + path.string() + ": " + std::strerror(code));
        };
        const fs::path temporary = path.parent_path() / ("." + path.filename().string() + ".part-" +
                                                         std::to_string(::getpid()));
        std::error_code ignored;
        fs::remove(temporary, ignored);
        int code = 0;
        {
            const sockets::Socket file(
                ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
            if (!file)
                throw failed(errno);
            if (::write(file.fd(), text.data(), text.size()) != static_cast<ssize_t>(text.size()))
                code = errno != 0 ? errno : ENOSPC;
            if (code == 0 && ::fsync(file.fd()) != 0 && errno != EINVAL && errno != ENOTSUP)
                code = errno;
        }
        // Unlike a rename, a link never replaces an existing file.
        if (code == 0 && ::link(temporary.c_str(), path.c_str()) != 0)
            code = errno;
        fs::remove(temporary, ignored);
        if (code != 0)
            throw failed(code);
        m_made.push_back(path);
    }
    void keep() noexcept { m_made.clear(); }

private:
    std::vector<fs::path> m_made;
};

void need(bool ok, const char* what) {
    if (!ok)
        throw util::Error(std::string("make a certificate: ") + what + ": " + openssl_reason());
}

template <class Write>
std::string pem_text(const Write& write) {
    const BioPtr out(BIO_new(BIO_s_mem()));
    need(out && write(out.get()) == 1, "write PEM");
    char* text = nullptr;
    const long size_bytes = BIO_get_mem_data(out.get(), &text);
    return {text, static_cast<std::size_t>(size_bytes)};
}
std::string to_pem(X509* certificate) {
    return pem_text([&](BIO* out) { return PEM_write_bio_X509(out, certificate); });
}
std::string to_pem(EVP_PKEY* key) {
    return pem_text([&](BIO* out) {
        return PEM_write_bio_PKCS8PrivateKey(out, key, nullptr, nullptr, 0, nullptr, nullptr);
    });
}

struct Pair {
    CertificatePtr certificate;
    KeyPtr key;
};

void add(X509* certificate, X509* issuer, int kind, const std::string& value) {
    X509V3_CTX context{};
    X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
    const std::unique_ptr<X509_EXTENSION, FreeBy<X509_EXTENSION_free>> extension(
        X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
    need(extension && X509_add_ext(certificate, extension.get(), -1) == 1, "add what it is for");
}

/// @param ca null: self-signed
Pair make_pair(const std::string& name, const std::string& role, int days, const Pair* ca) {
    Pair out{CertificatePtr(X509_new()), KeyPtr(EVP_EC_gen("P-256"))};
    need(out.certificate && out.key, "make a key");
    X509* certificate = out.certificate.get();
    X509* issuer = ca != nullptr ? ca->certificate.get() : certificate;
    // 159 random bits, the first of them set: positive, and always of the same length.
    std::array<unsigned char, 20> serial{};
    need(RAND_bytes(serial.data(), static_cast<int>(serial.size())) == 1, "make a serial number");
    serial[0] = static_cast<unsigned char>((serial[0] & 0x7f) | 0x40);
    const std::unique_ptr<BIGNUM, FreeBy<BN_free>> number(
        BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
    need(number && BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate)) != nullptr,
         "set the serial number");
    need(X509_set_version(certificate, 2) == 1 &&
             X509_gmtime_adj(X509_getm_notBefore(certificate), -kClockTolerance_s) != nullptr &&
             X509_time_adj_ex(X509_getm_notAfter(certificate), days, 0, nullptr) != nullptr &&
             X509_set_pubkey(certificate, out.key.get()) == 1,
         "set its time");
    X509_NAME* subject = X509_get_subject_name(certificate);
    need(X509_NAME_add_entry_by_txt(subject, "O", MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>("Terravox farm"), -1, -1,
                                    0) == 1 &&
             X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                                        reinterpret_cast<const unsigned char*>(name.c_str()), -1,
                                        -1, 0) == 1 &&
             X509_set_issuer_name(certificate, X509_get_subject_name(issuer)) == 1,
         "set its name");
    add(certificate, issuer, NID_subject_key_identifier, "hash");
    if (ca == nullptr) {
        add(certificate, issuer, NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
        add(certificate, issuer, NID_key_usage, "critical,keyCertSign,cRLSign");
    } else {
        add(certificate, issuer, NID_authority_key_identifier, "keyid");
        add(certificate, issuer, NID_basic_constraints, "critical,CA:FALSE");
        add(certificate, issuer, NID_key_usage, "critical,digitalSignature");
        add(certificate, issuer, NID_ext_key_usage, "serverAuth,clientAuth");
        add(certificate, issuer, NID_subject_alt_name,
            "DNS:" + std::string(kFarmName) + (name == kFarmName ? "" : ",DNS:" + name) +
                ",URI:" + std::string(kRoleUri) + role);
    }
    need(X509_sign(certificate, ca != nullptr ? ca->key.get() : out.key.get(), EVP_sha256()) > 0,
         "sign it");
    return out;
}

void check_name(const std::string& name) {
    const bool letters = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
    });
    if (name.empty() || name.size() > 63 || !letters || name.front() == '.' ||
        name.front() == '-' || name.back() == '.' || name.find("..") != std::string::npos ||
        name == "ca")
        throw util::UsageError(
            "make a certificate for '" + name +
            "': no such name; allowed: 1 to 63 small letters, digits, '-' and '.', not \"ca\"");
}

Pair read_ca(const fs::path& folder) {
    auto known = parse_certificates(text_of_pem(folder / "ca.pem", "CA certificate"));
    Pair out;
    out.key = parse_key(text_of_pem(folder / "ca.key", "key of the CA"));
    if (known.empty() || !out.key ||
        X509_check_private_key(known.front().get(), out.key.get()) != 1) {
        ERR_clear_error();
        throw util::Error("read the CA in " + folder.string() +
                          ": ca.pem and ca.key do not belong together");
    }
    out.certificate = std::move(known.front());
    return out;
}

void add_revoked(X509_CRL* list, X509* certificate, const std::string& file) {
    X509_REVOKED* known = nullptr;
    if (X509_CRL_get0_by_cert(list, &known, certificate) == 1)
        throw util::Error("revoke " + file + ": it is revoked already");
    std::unique_ptr<X509_REVOKED, FreeBy<X509_REVOKED_free>> entry(X509_REVOKED_new());
    const std::unique_ptr<ASN1_TIME, FreeBy<ASN1_TIME_free>> now(X509_gmtime_adj(nullptr, 0));
    need(entry && now &&
             X509_REVOKED_set_serialNumber(entry.get(), X509_get_serialNumber(certificate)) == 1 &&
             X509_REVOKED_set_revocationDate(entry.get(), now.get()) == 1 &&
             X509_CRL_add0_revoked(list, entry.get()) == 1,
         "add it to the list of revoked ones");
    (void)entry.release();  // now owned by the list
}

/// @throws UsageError
void check_request(const std::vector<std::string>& names, int days, const std::string& role) {
    if (!role.empty() && role != kWorkerRole && role != kCoordinatorRole)
        throw util::UsageError("make certificates of role '" + role + "'; allowed: " +
                               std::string(kWorkerRole) + ", " + std::string(kCoordinatorRole));
    for (const auto& name : names)
        check_name(name);
    for (auto name = names.begin(); name != names.end(); ++name)
        if (std::find(names.begin(), name, *name) != name)
            throw util::UsageError("make a certificate for '" + *name +
                                   "': it is named twice; allowed: each name once");
    if (days < 1 || days > kMaxCertificate_days)
        throw util::UsageError("make certificates for " + std::to_string(days) +
                               " days; allowed: 1 to " + std::to_string(kMaxCertificate_days));
}

/// @throws Error when only one of the CA's two files exists
bool has_ca_files(const fs::path& folder) {
    const bool has_pem = fs::exists(folder / "ca.pem");
    const bool has_key = fs::exists(folder / "ca.key");
    if (has_pem != has_key)
        throw util::Error("make certificates in " + folder.string() + ": it has " +
                          (has_pem ? "ca.pem without ca.key" : "ca.key without ca.pem") +
                          "; allowed: both, or none");
    return has_pem;
}

/// @throws Error when a file of one of the names exists
void check_unused(const fs::path& folder, const std::vector<std::string>& names) {
    for (const auto& name : names)
        for (const char* ending : {".pem", ".key"})
            if (const auto path = folder / (name + ending); fs::exists(path))
                throw util::Error("make a certificate: " + path.string() +
                                  " is there; allowed: names without files");
}

/// Makes a folder that is accessible to its owner only, if it does not exist.
void make_folder(const fs::path& folder) {
    std::error_code failed;
    if (!fs::is_directory(folder)) {
        fs::create_directories(folder, failed);
        if (!failed)
            fs::permissions(folder, fs::perms::owner_all, failed);
    }
    if (failed)
        throw util::Error("make the folder " + folder.string() + ": " + failed.message());
}

Pair unexpired_ca(const fs::path& folder) {
    Pair ca = read_ca(folder);
    if (X509_cmp_current_time(X509_get0_notAfter(ca.certificate.get())) < 0)
        throw util::Error("read the CA in " + folder.string() + ": ca.pem has expired");
    return ca;
}

Pair new_ca(const fs::path& folder, NewFiles& files) {
    Pair ca = make_pair("Terravox farm CA", {}, kMaxCertificate_days, nullptr);
    files.write(folder / "ca.key", to_pem(ca.key.get()), kPrivate);
    files.write(folder / "ca.pem", to_pem(ca.certificate.get()), kPublic);
    return ca;
}

}  // namespace

void revoke_certs(const fs::path& folder, const std::vector<std::string>& names) {
    for (const auto& name : names)
        check_name(name);
    const Pair ca = read_ca(folder);
    const fs::path path = find_revocation_list(folder / "ca.pem");
    CrlPtr list;
    if (fs::exists(path)) {
        list = parse_crl(text_of_pem(path, "list of revoked certificates"));
        if (!list || X509_CRL_verify(list.get(), ca.key.get()) != 1) {
            ERR_clear_error();
            throw util::Error("read the revoked certificates " + path.string() +
                              ": this CA has not signed them");
        }
    } else {
        list.reset(X509_CRL_new());
        need(list && X509_CRL_set_version(list.get(), 1) == 1 &&
                 X509_CRL_set_issuer_name(list.get(),
                                          X509_get_subject_name(ca.certificate.get())) == 1,
             "begin a list of revoked ones");
    }
    for (const auto& name : names) {
        const fs::path file = folder / (name + ".pem");
        const auto chain = parse_certificates(text_of_pem(file, "certificate"));
        if (chain.empty() || X509_verify(chain.front().get(), ca.key.get()) != 1) {
            ERR_clear_error();
            throw util::Error("revoke " + file.string() +
                              ": the CA in this folder has not signed it");
        }
        add_revoked(list.get(), chain.front().get(), file.string());
    }
    const std::unique_ptr<ASN1_TIME, FreeBy<ASN1_TIME_free>> now(X509_gmtime_adj(nullptr, 0));
    const std::unique_ptr<ASN1_TIME, FreeBy<ASN1_TIME_free>> until(
        X509_gmtime_adj(nullptr, kMaxCertificate_days * kDay_s));
    need(now && until && X509_CRL_set1_lastUpdate(list.get(), now.get()) == 1 &&
             X509_CRL_set1_nextUpdate(list.get(), until.get()) == 1 &&
             X509_CRL_sort(list.get()) == 1 &&
             X509_CRL_sign(list.get(), ca.key.get(), EVP_sha256()) > 0,
         "sign the list of revoked ones");
    util::write_file_atomically(
        path, pem_text([&](BIO* out) { return PEM_write_bio_X509_CRL(out, list.get()); }));
}

void make_certs(const fs::path& folder, const std::vector<std::string>& names, int days,
                const std::string& role) {
    const std::vector<std::string> wanted =
        names.empty() ? std::vector<std::string>{"coordinator", "worker"} : names;
    check_request(wanted, days, role);
    const bool has_ca = has_ca_files(folder);
    check_unused(folder, wanted);
    make_folder(folder);
    NewFiles files;
    const Pair ca = has_ca ? unexpired_ca(folder) : new_ca(folder, files);
    for (const auto& name : wanted) {
        const Pair one = make_pair(
            name,
            !role.empty() ? role
                          : std::string(name == kCoordinatorRole ? kCoordinatorRole : kWorkerRole),
            days, &ca);
        files.write(folder / (name + ".key"), to_pem(one.key.get()), kPrivate);
        files.write(folder / (name + ".pem"), to_pem(one.certificate.get()), kPublic);
    }
    files.keep();
}

}  // namespace terravox::net
