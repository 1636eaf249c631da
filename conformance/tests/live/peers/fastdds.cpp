// A flight controller of PX4 1.17 with Fast DDS 2, on the loopback interface: fastdds DOMAIN
//
// It sends an ArmingCheckRequest every 100 ms, and accepts each registration.
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

/// A CDR payload with its encapsulation header.
using Message = std::vector<unsigned char>;

/// The positions of fields in a payload.
constexpr size_t TIMESTAMP = 4, REQUEST_ID = 12, MASK = 16, SUCCESS = 48, UNREGISTERED_ID = 37;

/// A bit for each registration.
std::atomic<std::uint32_t> registrations{0};

/// A type whose messages are serialized already.
class RawType : public TopicDataType {
public:
    explicit RawType(const std::string& name) {
        setName(("px4_msgs::msg::dds_::" + name + "_").c_str());
        m_typeSize = 128;
    }
    bool serialize(void* data, SerializedPayload_t* payload) override {
        const auto& message = *static_cast<Message*>(data);
        std::memcpy(payload->data, message.data(), message.size());
        payload->length = message.size();
        payload->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(SerializedPayload_t* payload, void* data) override {
        static_cast<Message*>(data)->assign(payload->data, payload->data + payload->length);
        return true;
    }
    std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
        return [data] { return static_cast<Message*>(data)->size(); };
    }
    void* createData() override { return new Message; }
    void deleteData(void* data) override { delete static_cast<Message*>(data); }
    bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

/// A message that contains only the time since the start.
Message empty_message(size_t size) {
    static const auto start = std::chrono::steady_clock::now();
    const std::uint64_t time = std::chrono::duration_cast<std::chrono::microseconds>(
        std::chrono::steady_clock::now() - start).count() + 1;
    Message message(size);
    message[1] = 1;
    std::memcpy(&message[TIMESTAMP], &time, sizeof time);
    return message;
}

/// Passes each message to a function.
class Listener : public DataReaderListener {
public:
    explicit Listener(std::function<void(const Message&)> handle) : handle(std::move(handle)) {}

    void on_data_available(DataReader* reader) override {
        Message message;
        SampleInfo info;
        while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
            if (info.valid_data) handle(message);
        }
    }

private:
    std::function<void(const Message&)> handle;
};

/// Adds a registration, and replies.
void add_registration(const Message& request, DataWriter* replies) {
    static unsigned char next = 0;
    if (request.size() < SUCCESS || next >= 32) return;
    Message reply = empty_message(SUCCESS + 4);
    std::memcpy(&reply[REQUEST_ID], &request[REQUEST_ID], SUCCESS - REQUEST_ID);
    const unsigned char values[] = {1, next, 0xff, 0xff};
    std::memcpy(&reply[SUCCESS], values, sizeof values);
    registrations |= 1u << next++;
    replies->write(&reply);
}

/// Removes a registration.
void remove_registration(const Message& message) {
    if (message.size() > UNREGISTERED_ID) registrations &= ~(1u << message[UNREGISTERED_ID] % 32);
}

Topic* create_topic(DomainParticipant* participant, const std::string& name, const std::string& type_name) {
    TypeSupport type(new RawType(type_name));
    type.register_type(participant);
    return participant->create_topic("rt/fmu/" + name, type.get_type_name(), TOPIC_QOS_DEFAULT);
}

int main(int, char** arguments) {
    DomainParticipantQos qos;
    qos.name("/fast");
    auto transport = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    transport->interfaceWhiteList.push_back("127.0.0.1");
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(transport);
    const int domain = std::atoi(arguments[1]);
    for (int index = 0; index < 4; ++index) {
        Locator_t locator;
        IPLocator::setIPv4(locator, 127, 0, 0, 1);
        locator.port = 7410 + 250 * domain + 2 * index;
        qos.wire_protocol().builtin.initialPeersList.push_back(locator);
    }
    auto* participant = DomainParticipantFactory::get_instance()->create_participant(domain, qos);
    if (participant == nullptr) return 1;
    DataWriterQos writer_qos;
    writer_qos.reliability().kind = BEST_EFFORT_RELIABILITY_QOS;
    writer_qos.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
    auto* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
    auto* requests = publisher->create_datawriter(
        create_topic(participant, "out/arming_check_request_v1", "ArmingCheckRequest"), writer_qos);
    auto* replies = publisher->create_datawriter(
        create_topic(participant, "out/register_ext_component_reply", "RegisterExtComponentReply"), writer_qos);
    Listener joining([replies](const Message& request) { add_registration(request, replies); });
    Listener leaving(remove_registration);
    auto* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
    auto* joined = subscriber->create_datareader(
        create_topic(participant, "in/register_ext_component_request", "RegisterExtComponentRequest"),
        DATAREADER_QOS_DEFAULT, &joining);
    auto* left = subscriber->create_datareader(
        create_topic(participant, "in/unregister_ext_component", "UnregisterExtComponent"),
        DATAREADER_QOS_DEFAULT, &leaving);
    if (!requests || !replies || !joined || !left) return 1;
    for (unsigned char id = 0;; ++id) {
        Message request = empty_message(20);
        const std::uint32_t mask = registrations;
        request[REQUEST_ID] = id;
        std::memcpy(&request[MASK], &mask, sizeof mask);
        requests->write(&request);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}
